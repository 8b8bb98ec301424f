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
  double lost_px = 0;                            ///< loss of length of their sides
};

/// Guesses a board of markers from images: its dictionary, counts and proportions.
class MarkerGuess {
 public:
  /// Looks for markers of all dictionaries, dark on white or, if there are none, white on dark.
  void look(const GrayImage& image);

  /// True if further images would add nothing.
  [[nodiscard]] bool isSure() const;

  /// The board in the images and the flag to give; empty if no markers are neighbours.
  [[nodiscard]] std::string text() const;

 private:
  void keep(MarkedImage seen);
  // The most informative images: those with the most markers, the lowest id and the highest id.
  [[nodiscard]] std::vector<const MarkedImage*> tellingImages(std::size_t print) const;

  std::vector<MarkedImage> seen_;
  std::set<std::pair<std::size_t, int>> ids_;  ///< of prints and markers
  int num_without_news_ = 0;                   ///< number of last images without new ids
};

}  // namespace alidade
