// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/ray_polynomial.h"

namespace alidade {

/// Radial distortion by a division: a point (mx, my) of the distorted plane, R = |(mx, my)|, has the ray
/// (mx, my, h), h = 1 + k1 R^2 + k2 R^4, and so the undistorted point (mx, my) / h.
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2 (no unit; COLMAP's k is k1, and has no k2).
/// Domain: see RayPolynomial; with k1 < 0 it goes on behind the camera plane, where h < 0. COLMAP's
/// projection does the same, but its inverse gives the opposite of such rays. Inverse: closed form. Forward:
/// as `ocam`. Source: Fitzgibbon 2001, Simultaneous linear estimation of multiple view geometry and lens
/// distortion, CVPR, section 3; the formula is that of COLMAP's DIVISION and SIMPLE_DIVISION.
struct Division : detail::RayPolynomial<Division, 2> {
  static constexpr std::string_view kId = "division";
  static constexpr std::string_view kAliases = "simple_division";
  static constexpr bool kIsCandidate = false;
  static constexpr std::array<std::string_view, 2> kLensParamNames = {"k1", "k2"};
  static constexpr std::array<int, 2> kPowers = {2, 4};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"pinhole"}};
};

}  // namespace alidade
