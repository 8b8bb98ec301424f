// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/compare/image_match.h"
#include "alidade/compare/projection_difference.h"
#include "alidade/core/image.h"

namespace alidade {

/// The part of the larger of two images that the smaller one may show.
struct CropSuspicion {
  bool is_a_larger = false;
  double focal_a_px = 0;  ///< at the image centre: geometric mean of both axes
  double focal_b_px = 0;
  ImageSize part;                         ///< in the larger image
  std::optional<Eigen::Vector2i> corner;  ///< from the principal points; nothing: unknown
};

/// Images of the same shape and of different sizes are assumed to be resized. If the sides differ by more
/// than a tenth, but the focal lengths in pixels by at most 2 %, one image is probably a crop of the other:
/// resizing changes both, but cropping changes only the sides.
///
/// @returns nothing if there is no such suspicion
[[nodiscard]] std::optional<CropSuspicion> suspectCrop(const ComparedCamera& a, const ComparedCamera& b,
                                                       const ImageMatch& match);

}  // namespace alidade
