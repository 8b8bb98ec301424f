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
  struct Seen {
    GrayImage image;
    std::vector<std::vector<SeenMarker>> markers;  ///< by print
    double lost_px = 0;                            ///< loss of length of their sides
  };
  void keep(Seen seen);
  // The most informative images: those with the most markers, the lowest id and the highest id.
  [[nodiscard]] std::vector<std::size_t> tellingImages(std::size_t print) const;

  std::vector<Seen> seen_;
  std::set<std::pair<std::size_t, int>> ids_;  ///< of prints and markers
  int num_without_news_ = 0;                   ///< number of last images without new ids
};

}  // namespace alidade
