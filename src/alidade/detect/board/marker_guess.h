// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/detect/board/seen_markers.h"

namespace alidade {

/// An image and its markers.
struct MarkedImage {
  GrayImage image;
  std::vector<std::vector<SeenMarker>> markers;  ///< by print
  double lost_px = 0;                            ///< by which their sides are too short
};

/// Guesses a board of markers from images of it: its dictionary, counts and proportions.
class MarkerGuess {
 public:
  /// Looks for markers of all dictionaries, dark on white or, if there are none, white on dark.
  void look(const GrayImage& image);

  /// True when further images would say no more.
  [[nodiscard]] bool isSure() const;

  /// What the images show and the flag to give; empty if no markers lie beside one another.
  [[nodiscard]] std::string text() const;

 private:
  void keep(MarkedImage seen);
  // Those whose markers tell most: the most, the lowest and the highest.
  [[nodiscard]] std::vector<const MarkedImage*> tellingImages(std::size_t print) const;

  std::vector<MarkedImage> seen_;
  std::set<std::pair<std::size_t, int>> ids_;  ///< of prints and markers
  int num_without_news_ = 0;                   ///< of the last images, that showed no further ids
};

}  // namespace alidade
