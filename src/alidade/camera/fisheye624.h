// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/equidistant_plane.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Fisheye lenses as a polynomial in the field angle, then tangential terms and those of a thin prism in the
/// plane of its image. With t = theta of the ray, r = t (1 + k0 t^2 + k1 t^4 + ... + k5 t^12), x = r X / rho,
/// y = r Y / rho and r2 = x^2 + y^2:
///
///   mx = x + p0 (r2 + 2 x^2) + 2 p1 x y + s0 r2 + s1 r2^2
///   my = y + p1 (r2 + 2 y^2) + 2 p0 x y + s2 r2 + s3 r2^2
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k0 to k5, p0, p1, s0 to s3 (no unit; this is the order
/// of Project Aria and COLMAP). Without k4, k5, p and s it is `kannala_brandt`, whose k1 is k0. Domain and
/// inverse: as `thin_prism_fisheye`. Source: the FisheyeRadTanThinPrism model of Project Aria's tools
/// ("Fisheye624"), which is COLMAP's RAD_TAN_THIN_PRISM_FISHEYE. Both programs stop at 90 degrees or mirror
/// what lies beyond; the formula goes on.
struct Fisheye624 : EquidistantFormula<Fisheye624, 12> {
  static constexpr std::string_view kId = "fisheye624";
  static constexpr std::string_view kAliases = "fisheye_rad_tan_thin_prism rad_tan_thin_prism_fisheye";
  static constexpr std::array<std::string_view, 12> kLensParamNames = {"k0", "k1", "k2", "k3", "k4", "k5",
                                                                       "p0", "p1", "s0", "s1", "s2", "s3"};
  static constexpr bool kIsOneToOneWithoutFold = false;

  // To and from the first four coefficients.
  static double toKannalaBrandt(const double* k, double* to) {
    std::copy_n(k, 4, to);
    return std::all_of(k + 4, k + 12, [](double value) { return value == 0; }) ? 1.0 : 0.0;
  }
  static double fromKannalaBrandt(const double* from, double* k) {
    std::copy_n(from, 4, k);
    std::fill(k + 4, k + 12, 0.0);
    return 1.0;
  }

  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = true;
  static constexpr std::string_view kFlexibleId = "";
  static constexpr std::array<LensVector, 3> kVectors = {LensVector{6, 7}, LensVector{8, 10},
                                                         LensVector{9, 11}};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {
      SharedLens{"kannala_brandt", toKannalaBrandt, fromKannalaBrandt, true}};

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialFactor<T> radial(const K* k, const T& t2) {
    T a = 0.0 * t2 + k[5];
    T da = 6.0 * a;
    for (int i = 4; i >= 0; --i) {
      a = a * t2 + k[i];
      da = da * t2 + (i + 1.0) * k[i];
    }
    return {1.0 + t2 * a, da};
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> warp(const K* k, const T& x, const T& y) {
    const detail::RadialFactor<T> f = radial(k, T(x * x + y * y));
    const detail::WarpSample<T> s = afterRadial(k, T(f.a * x), T(f.a * y));
    const T xx = f.a + 2.0 * f.da * x * x;
    const T xy = 2.0 * f.da * x * y;
    const T yy = f.a + 2.0 * f.da * y * y;
    return {.mx = s.mx,
            .my = s.my,
            .dmx_dx = s.dmx_dx * xx + s.dmx_dy * xy,
            .dmx_dy = s.dmx_dx * xy + s.dmx_dy * yy,
            .dmy_dx = s.dmy_dx * xx + s.dmy_dy * xy,
            .dmy_dy = s.dmy_dx * xy + s.dmy_dy * yy};
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void lensDerivatives(const K* k, const T& x, const T& y, T* dmx, T* dmy) {
    const T t2 = x * x + y * y;
    const T a = radial(k, t2).a;
    const T px = a * x;
    const T py = a * y;
    const detail::WarpSample<T> s = afterRadial(k, px, py);
    T power_x = s.dmx_dx * x + s.dmx_dy * y;
    T power_y = s.dmy_dx * x + s.dmy_dy * y;
    for (int i = 0; i < 6; ++i) {
      dmx[i] = power_x = power_x * t2;
      dmy[i] = power_y = power_y * t2;
    }
    T tangential_x[2];
    T tangential_y[2];
    detail::tangentialDerivatives(px, py, tangential_x, tangential_y);
    dmx[6] = tangential_x[1];
    dmx[7] = tangential_x[0];
    dmy[6] = tangential_y[1];
    dmy[7] = tangential_y[0];
    detail::prismDerivatives(px, py, dmx + 8, dmy + 8);
  }

 private:
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> afterRadial(const K* k, const T& x, const T& y) {
    const T zero = 0.0 * x;
    detail::WarpSample<T> s =
        detail::radialTangentialWarp(x, y, detail::RadialFactor<T>{zero + 1.0, zero}, k[7], k[6]);
    detail::addPrism(k + 8, x, y, s);
    return s;
  }
};

}  // namespace alidade
