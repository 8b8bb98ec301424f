// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// A marker and its corners, clockwise from its top left; metres on a board, pixels in an image.
struct Marker {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;
};
using SeenMarker = Marker;  ///< in an image

[[nodiscard]] inline Eigen::Vector2d middleOf(const std::array<Eigen::Vector2d, 4>& corners) {
  return 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
}

/// Appearance of printed markers.
struct MarkerPrint {
  std::string dictionary;  ///< one of OpenCV's dictionaries
  int border = 1;          ///< width in cells
  /// Nothing is printed within half a cell of its sides, except near its corners.
  bool is_apart = false;

  [[nodiscard]] int numCells() const;  ///< along a side, including the border
  friend bool operator==(const MarkerPrint&, const MarkerPrint&) = default;
};

/// The scales at which an image is searched for markers, one after the other until enough are seen: the first
/// is fast, the last finds cells of a few pixels. Empty if the image is too small for any marker.
struct MarkerLook {
  double scale = 1;
  bool is_quick = false;  ///< finds only large markers
};
[[nodiscard]] std::vector<MarkerLook> markerLooks(ImageSize size);

/// The markers of each print; an id may occur more than once.
struct SeenMarkers {
  std::vector<std::vector<SeenMarker>> of_prints;
  int num_framed = 0;  ///< outlines with a frame of one colour, as markers have

  /// False if a look at a larger scale is not worth its time.
  [[nodiscard]] bool areFramed() const { return num_framed >= 3; }
};

/// Searches for markers, dark on white or white on dark. The outlines are searched only once for all prints;
/// as soon as a print has `enough` markers, those after it are not tried any more.
[[nodiscard]] SeenMarkers seeMarkers(const GrayImage& image, std::span<const MarkerPrint> prints,
                                     MarkerLook look, std::size_t enough = SIZE_MAX);

}  // namespace alidade
