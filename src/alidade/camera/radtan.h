// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Radial and tangential (Brown-Conrady) distortion of the perspective plane. With x = X/Z, y = Y/Z,
/// r2 = x^2 + y^2 and a = 1 + k1 r2 + k2 r2^2 + k3 r2^3:
///
///   mx = x a + 2 p1 x y + p2 (r2 + 2 x^2)
///   my = y a + p1 (r2 + 2 y^2) + 2 p2 x y
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, p1, p2, k3 (no unit; this is OpenCV's order).
/// Domain: Z > 0 and field angle below the first fold over all azimuths. The map is the gradient of a
/// potential, so its Jacobian is symmetric and a positive determinant on a disc makes it one-to-one there.
/// Inverse: safeguarded Newton iteration inside that disc.
/// Source: Brown 1966, Decentering distortion of lenses, Photogrammetric Engineering 32(3).
struct Radtan : PlaneFormula<Radtan, 5> {
  static constexpr std::string_view kId = "radtan";
  static constexpr std::string_view kAliases = "plumb_bob brown_conrady opencv5 pinhole-radtan";
  static constexpr std::array<std::string_view, 5> kLensParamNames = {"k1", "k2", "p1", "p2", "k3"};

  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = true;
  static constexpr std::string_view kFlexibleId = "rational";
  static constexpr std::array<LensVector, 1> kVectors = {LensVector{3, 2}};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"pinhole"}};

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialFactor<T> radial(const K* k, const T& r2) {
    return {1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4])), k[0] + r2 * (2.0 * k[1] + r2 * (3.0 * k[4]))};
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> warp(const K* k, const T& x, const T& y) {
    return detail::radialTangentialWarp(x, y, radial(k, T(x * x + y * y)), k[2], k[3]);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void lensDerivatives(const K*, const T& x, const T& y, T* dmx, T* dmy) {
    const T r2 = x * x + y * y;
    const T r4 = r2 * r2;
    dmx[0] = x * r2;
    dmx[1] = x * r4;
    dmx[4] = x * r4 * r2;
    dmy[0] = y * r2;
    dmy[1] = y * r4;
    dmy[4] = y * r4 * r2;
    detail::tangentialDerivatives(x, y, dmx + 2, dmy + 2);
  }
};

}  // namespace alidade
