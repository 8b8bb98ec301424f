// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/radtan.h"
#include "alidade/camera/skewed.h"
#include "alidade/core/lanes.h"

namespace alidade {

namespace detail {

/// `radtan` with one more radial coefficient, k4 r2^4.
struct Brown8 : PlaneFormula<Brown8, 6> {
  static constexpr std::array<std::string_view, 6> kLensParamNames = {"k1", "k2", "p1", "p2", "k3", "k4"};
  static constexpr bool kIsPolynomial = true;
  static constexpr std::array<LensVector, 1> kVectors = {LensVector{3, 2}};

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static RadialFactor<T> radial(const K* k, const T& r2) {
    return {1.0 + r2 * (k[0] + r2 * (k[1] + r2 * (k[4] + r2 * k[5]))),
            k[0] + r2 * (2.0 * k[1] + r2 * (3.0 * k[4] + r2 * (4.0 * k[5])))};
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static WarpSample<T> warp(const K* k, const T& x, const T& y) {
    return radialTangentialWarp(x, y, radial(k, T(x * x + y * y)), k[2], k[3]);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void lensDerivatives(const K* k, const T& x, const T& y, T* dmx, T* dmy) {
    Radtan::lensDerivatives(k, x, y, dmx, dmy);
    const T r2 = x * x + y * y;
    dmx[5] = dmx[4] * r2;
    dmy[5] = dmy[4] * r2;
  }
};

}  // namespace detail

/// Brown's distortion as photogrammetry programs state it: `radtan` with one more radial coefficient and the
/// skew of the sensor. With x = X/Z, y = Y/Z, r2 = x^2 + y^2 and
/// a = 1 + k1 r2 + k2 r2^2 + k3 r2^3 + k4 r2^4:
///
///   dx = x a + 2 p1 x y + p2 (r2 + 2 x^2)
///   dy = y a + p1 (r2 + 2 y^2) + 2 p2 x y
///   mx = dx + skew dy,  my = dy
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, p1, p2, k3, k4, skew (no unit). Agisoft
/// Metashape swaps p1 and p2, and states fx = f + B1, fy = f, skew = B2 / fx. Domain and inverse: as
/// `radtan`, whose reasons hold before the skew. Source: Brown 1971, Close-range camera calibration,
/// Photogrammetric Engineering 37(8); the formula is that of Metashape's frame camera (its user manual,
/// appendix "Camera models").
struct Brown : SkewFormula<Brown, detail::Brown8> {
  static constexpr std::string_view kId = "brown";
  static constexpr std::string_view kAliases = "metashape agisoft";
  static constexpr bool kIsCandidate = false;
  static constexpr std::array<LensVector, 1> kVectors = {LensVector{3, 2}};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"radtan"}};
};

}  // namespace alidade
