// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/ray_polynomial.h"
#include "alidade/camera/skewed.h"

namespace alidade {

namespace detail {

/// `ocam` on a sensor with axes at right angles.
struct OcamLens : RayPolynomial<OcamLens, 5> {
  static constexpr std::array<std::string_view, 5> kLensParamNames = {"a2", "a3", "a4", "a5", "a6"};
  static constexpr std::array<int, 5> kPowers = {2, 3, 4, 5, 6};
};

}  // namespace detail

/// Scaramuzza's model for mirrors and fisheye lenses, which states the ray of a pixel as a polynomial. With
/// R = |(X, Y)|, the ray of the point (X, Y) of the sensor's plane is (X, Y, h), where
///
///   h  = 1 + a2 R^2 + a3 R^3 + a4 R^4 + a5 R^5 + a6 R^6
///   mx = X + skew Y
///   my = Y + shear X
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), a2 to a6, skew, shear (no unit). fx is pixels per
/// radian on the axis. OCamCalib states the same in pixels: with its polynomial f = b0 + b2 s^2 + b3 s^3 +
/// ..., b0 < 0 for a lens, a_i = b_i (-b0)^i / b0; its affine matrix (c d; e 1) has c = fx / fy, d = skew fx
/// / fy and e = shear, and fy = -b0. Domain: see RayPolynomial. Inverse: closed form. Forward: safeguarded
/// Newton iteration for R. A rotation about the axis changes skew and shear by opposite amounts, so that
/// poses cannot tell one from the other. Source: Scaramuzza, Martinelli and Siegwart 2006, A toolbox for
/// easily calibrating omnidirectional cameras, IROS, equations 3 and 4.
struct Ocam : SkewFormula<Ocam, detail::OcamLens, true> {
  static constexpr std::string_view kId = "ocam";
  static constexpr std::string_view kAliases = "scaramuzza ocamcalib";
  static constexpr std::string_view kRedundant = "shear";
  /// An equidistant lens to the fourth power of R.
  static constexpr std::array<double, 7> kStartLens = {-1.0 / 3, 0, -1.0 / 45, 0, 0, 0, 0};

  // To and from even polynomials.
  static double toDivision(const double* k, double* to) {
    to[0] = k[0];
    to[1] = k[2];
    return k[1] == 0 && k[3] == 0 && k[4] == 0 && k[5] == 0 && k[6] == 0 ? 1.0 : 0.0;
  }
  static double fromDivision(const double* from, double* k) {
    for (int i = 0; i < 7; ++i) k[i] = 0;
    k[0] = from[0];
    k[2] = from[1];
    return 1.0;
  }

  static constexpr std::array<LensVector, 1> kVectors = {LensVector{5, 6, -1}};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {
      SharedLens{"division", toDivision, fromDivision, true}};
};

}  // namespace alidade
