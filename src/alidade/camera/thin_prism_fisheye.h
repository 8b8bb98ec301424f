// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/equidistant_plane.h"
#include "alidade/camera/kannala_brandt.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// `kannala_brandt` with tangential terms and those of a thin prism, all in the equidistant plane. With
/// x = theta X / rho, y = theta Y / rho, r2 = x^2 + y^2 and a = 1 + k1 r2 + k2 r2^2 + k3 r2^3 + k4 r2^4:
///
///   mx = x a + 2 p1 x y + p2 (r2 + 2 x^2) + s1 r2
///   my = y a + p1 (r2 + 2 y^2) + 2 p2 x y + s2 r2
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, k3, k4, p1, p2, s1, s2 (no unit; COLMAP's order
/// is k1 k2 p1 p2 k3 k4 sx1 sy1). Domain: all directions up to the first fold over all azimuths, and to the
/// first angle whose image crosses itself; see `thin_prism`. Inverse: safeguarded Newton iteration inside
/// that disc. Source: the formula is that of COLMAP's THIN_PRISM_FISHEYE, after Weng, Cohen and Herniou 1992
/// (see `thin_prism`).
struct ThinPrismFisheye : EquidistantFormula<ThinPrismFisheye, 8> {
  static constexpr std::string_view kId = "thin_prism_fisheye";
  static constexpr std::array<std::string_view, 8> kLensParamNames = {"k1", "k2", "k3", "k4",
                                                                      "p1", "p2", "s1", "s2"};
  static constexpr bool kIsOneToOneWithoutFold = false;

  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = true;
  static constexpr std::string_view kFlexibleId = "";
  static constexpr std::array<LensVector, 2> kVectors = {LensVector{5, 4}, LensVector{6, 7}};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"kannala_brandt"}};

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialFactor<T> radial(const K* k, const T& r2) {
    return KannalaBrandt::factor(k, r2);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> warp(const K* k, const T& x, const T& y) {
    const T r2 = x * x + y * y;
    detail::WarpSample<T> s = detail::radialTangentialWarp(x, y, radial(k, r2), k[4], k[5]);
    s.mx = s.mx + k[6] * r2;
    s.my = s.my + k[7] * r2;
    s.dmx_dx = s.dmx_dx + 2.0 * k[6] * x;
    s.dmx_dy = s.dmx_dy + 2.0 * k[6] * y;
    s.dmy_dx = s.dmy_dx + 2.0 * k[7] * x;
    s.dmy_dy = s.dmy_dy + 2.0 * k[7] * y;
    return s;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void lensDerivatives(const K*, const T& x, const T& y, T* dmx, T* dmy) {
    const T r2 = x * x + y * y;
    T power = 0.0 * r2 + 1.0;
    for (int i = 0; i < 4; ++i) {
      power = power * r2;
      dmx[i] = x * power;
      dmy[i] = y * power;
    }
    detail::tangentialDerivatives(x, y, dmx + 4, dmy + 4);
    dmx[6] = dmy[7] = r2;
    dmx[7] = dmy[6] = 0.0 * r2;
  }
};

}  // namespace alidade
