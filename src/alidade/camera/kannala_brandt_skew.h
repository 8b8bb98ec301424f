// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/kannala_brandt.h"
#include "alidade/camera/skewed.h"

namespace alidade {

/// `kannala_brandt` with the skew of `cv::fisheye`: with (x, y) the map of `kannala_brandt`,
///
///   mx = x + skew y,  my = y
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, k3, k4, skew (no unit). Domain and inverse: as
/// `kannala_brandt`. Source: the formula is that of OpenCV's cv::fisheye with alpha = skew.
struct KannalaBrandtSkew : SkewFormula<KannalaBrandtSkew, KannalaBrandt> {
  static constexpr std::string_view kId = "kannala_brandt_skew";
  static constexpr bool kIsCandidate = false;
  static constexpr std::array<LensVector, 0> kVectors = {};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"kannala_brandt"}};
};

}  // namespace alidade
