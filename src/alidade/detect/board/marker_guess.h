// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/detect/board/seen_markers.h"

namespace alidade {

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
  struct Seen {
    GrayImage image;
    std::vector<std::vector<SeenMarker>> markers;  ///< by print
    double lost_px = 0;                            ///< by which their sides are too short
  };
  std::vector<Seen> seen_;
};

}  // namespace alidade
