// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/radtan.h"
#include "alidade/camera/stated_inverse.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Brown's distortion stated from the pixel to the ray: the map (dx, dy) of `radtan` takes the point (mx, my)
/// of the normalised plane to X/Z = dx(mx, my), Y/Z = dy(mx, my).
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, p1, p2, k3 (no unit). Domain: the largest cone
/// whose image lies in the disc about the axis in which `radtan` is one-to-one; its end at a fold costs a few
/// pixels, because the rays of pixels hardly move there. Inverse: closed form. Forward: Newton iteration for
/// (mx, my), from the solution of the radial part; for about one in a million rays near the end of the domain
/// it does not converge, and the ray has no pixel. Source: RS2_DISTORTION_INVERSE_BROWN_CONRADY of
/// librealsense, in its documentation and in rs2_deproject_pixel_to_point of older versions. Later ones undo
/// the map of the modified Brown-Conrady lens there instead, and all project with that map.
struct InverseBrown : LensFormula<InverseBrown, 5> {
  static constexpr std::string_view kId = "inverse_brown";
  static constexpr std::string_view kAliases = "inverse_brown_conrady";
  static constexpr bool kIsCandidate = false;
  static constexpr std::array<std::string_view, 5> kLensParamNames = Radtan::kLensParamNames;
  static constexpr double kMaxAngle = kPerspectiveMaxAngle;

  static constexpr LensFamily kFamily = LensFamily::kPerspective;
  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = true;
  static constexpr std::string_view kFlexibleId = "";
  static constexpr std::array<LensVector, 1> kVectors = {LensVector{3, 2}};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"pinhole"}};

  static double maxAngle(const double* k) {
    constexpr int kNumAzimuths = 512;
    const double radius = lastRadius(k);
    double reach = HUGE_VAL;
    for (int i = 0; i < kNumAzimuths; ++i) {
      const double azimuth = 2 * std::numbers::pi * i / kNumAzimuths;
      const auto s = Radtan::warp(k, radius * std::cos(azimuth), radius * std::sin(azimuth));
      reach = std::min(reach, std::hypot(s.mx, s.my));
    }
    return std::min(kMaxAngle, std::atan(reach));
  }

  template <class T>
  static bool hasValue(const T*, const T* ray) {
    return ray[2] > 0.0;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    const T iz = 1.0 / ray[2];
    const T x = ray[0] * iz;
    const T y = ray[1] * iz;
    const auto warp = [k](const T& px, const T& py) ALIDADE_INLINE_LAMBDA { return Radtan::warp(k, px, py); };
    detail::quickInvertWarp(warp, RadialStart<K>{k}, x, y, m[0], m[1]);
    const detail::WarpSample<T> s = warp(m[0], m[1]);
    const T scale = 1.0 / s.det();
    const detail::WarpSample<T> back{.mx = x,
                                     .my = y,
                                     .dmx_dx = s.dmy_dy * scale,
                                     .dmx_dy = -s.dmx_dy * scale,
                                     .dmy_dx = -s.dmy_dx * scale,
                                     .dmy_dy = s.dmx_dx * scale};
    // The last step, through which automatic differentiation passes.
    const T rest_x = x - s.mx;
    const T rest_y = y - s.my;
    m[0] = m[0] + back.dmx_dx * rest_x + back.dmx_dy * rest_y;
    m[1] = m[1] + back.dmy_dx * rest_x + back.dmy_dy * rest_y;
    if (J_m_ray != nullptr) detail::warpJacobian(back, x, y, iz, J_m_ray);
    if (J_m_lens == nullptr) return;
    T dx[5];
    T dy[5];
    Radtan::lensDerivatives(k, m[0], m[1], dx, dy);
    for (int i = 0; i < 5; ++i) {
      J_m_lens[i] = -(back.dmx_dx * dx[i] + back.dmx_dy * dy[i]);
      J_m_lens[5 + i] = -(back.dmy_dx * dx[i] + back.dmy_dy * dy[i]);
    }
  }

  /// The radius of the disc in which the domain lies.
  struct Start {
    double radius = 0;
  };
  static Start makeStart(const double* k, double) { return {lastRadius(k)}; }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m, double,
                                                T* ray) {
    const T r2 = m[0] * m[0] + m[1] * m[1];
    const T nothing = lane::select(r2 <= start.radius * start.radius, T(0.0 * r2), T(r2 + lane::kNaN));
    const detail::WarpSample<T> s = Radtan::warp(k, m[0], m[1]);
    detail::makeUnitRay(T(s.mx + nothing), s.my, T(0.0 * r2 + 1.0), ray);
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    // quickUnlens() has all rays inside the cone, so that only one on its rim is left. A smaller angle is
    // that of a pixel beyond a fold.
    const detail::WarpSample<double> s = Radtan::warp(k, m[0], m[1]);
    if (!(std::hypot(s.mx, s.my) >= std::tan(max_angle))) return false;
    detail::makeUnitRay(s.mx, s.my, 1.0, ray);
    return true;
  }

 private:
  // The radius of the disc in which the map is one-to-one, which is the cone of `radtan` with the same
  // parameters.
  static double lastRadius(const double* k);

  // The inverse of the radial part.
  template <class K>
  struct RadialStart {
    const K* k;
    template <class T>
    ALIDADE_ALWAYS_INLINE T scale(const T& r2) const {
      const T r = lane::squareRoot(T(r2 + 1e-200));
      const T root = detail::firstRisingRoot(
          [&](const T& x) ALIDADE_INLINE_LAMBDA {
            const T x2 = x * x;
            const detail::RadialFactor<T> f = Radtan::radial(k, x2);
            const T slope = f.a + 2.0 * x2 * f.da;
            return detail::RisingValue<T>{x * f.a - r, slope, slope};
          },
          r);
      return root / r;
    }
  };
};

}  // namespace alidade
