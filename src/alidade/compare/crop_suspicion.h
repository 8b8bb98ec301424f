// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/compare/image_match.h"
#include "alidade/compare/projection_difference.h"
#include "alidade/core/image.h"

namespace alidade {

/// A part of the larger of two images that the smaller one may be.
struct CropSuspicion {
  bool is_a_larger = false;
  double focal_a_px = 0;  ///< by the image's middle: the root of the product of both axes' focal lengths
  double focal_b_px = 0;
  ImageSize part;                         ///< in the larger image
  std::optional<Eigen::Vector2i> corner;  ///< where the principal points put the part's; nothing: they do not
};

/// Images of one shape and of different sizes are compared as one that was resized. Where the sides differ by
/// more than a tenth, and focal lengths in pixels by at most 2 % all the same, it is likelier that one image
/// is a part of the other: resizing changes both alike, and cropping the sides alone.
///
/// @returns nothing where there is no such suspicion
[[nodiscard]] std::optional<CropSuspicion> suspectCrop(const ComparedCamera& a, const ComparedCamera& b,
                                                       const ImageMatch& match);

}  // namespace alidade
