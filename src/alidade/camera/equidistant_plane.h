// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/inverse_start.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/wide_angle.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Common part of the models that distort the plane of an equidistant lens, x = theta X / rho and
/// y = theta Y / rho with rho = |(X, Y)| and theta = atan2(rho, Z). M has radial(), warp() and
/// lensDerivatives() as for PlaneFormula.
template <class M, std::size_t kNum>
struct EquidistantFormula : LensFormula<M, kNum> {
  static constexpr double kMaxAngle = kWideMaxAngle;
  static constexpr LensFamily kFamily = LensFamily::kWide;

  template <class T>
  static bool hasValue(const T*, const T* ray) {
    return ray[2] > 0.0 || ray[0] * ray[0] + ray[1] * ray[1] > 0.0;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    const T z = ray[2];
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const T q = detail::angleOverRadius(rho2, z);
    const T x = q * ray[0];
    const T y = q * ray[1];
    const detail::WarpSample<T> s = M::warp(k, x, y);
    m[0] = s.mx;
    m[1] = s.my;
    if (J_m_ray != nullptr) {
      T J[6];
      detail::radialJacobian(ray, q, detail::angleOverRadiusSlope(rho2, z, q), T(-1.0 / (rho2 + z * z)), 1.0,
                             J);
      detail::warpJacobian(s, J, J_m_ray);
    }
    if (J_m_lens != nullptr) M::lensDerivatives(k, x, y, J_m_lens, J_m_lens + M::kNumLensParams);
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const auto warp = [k](double x, double y) { return M::warp(k, x, y); };
    double x = 0;
    double y = 0;
    // Adds a nanoradian so that a ray on the rim of the domain survives rounding.
    if (!detail::invertWarp(warp, m[0], m[1], max_angle + 1e-9, x, y)) return false;
    toRay(x, y, ray);
    return true;
  }

  using Start = detail::InverseStart;
  static Start makeStart(const double* k, double max_angle) {
    return {[k](double r2) { return M::radial(k, r2); }, max_angle};
  }
  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m,
                                                double max_angle, T* ray) {
    T x;
    T y;
    detail::quickInvertWarp([k](const T& px, const T& py)
                                ALIDADE_INLINE_LAMBDA { return M::warp(k, px, py); },
                            start, m[0], m[1], x, y);
    const T theta2 = x * x + y * y;
    x = lane::select(theta2 <= max_angle * max_angle, x, T(0.0 * x + lane::kNaN));
    toRay(x, y, ray);
  }

 private:
  template <class T>
  ALIDADE_ALWAYS_INLINE static void toRay(const T& x, const T& y, T* ray) {
    const T theta = lane::squareRoot(T(x * x + y * y));
    T sine;
    T cosine;
    lane::sineCosine(theta, sine, cosine);
    // On the axis, sin(theta) / theta is 0 / 0 and its limit is 1.
    const T scale = lane::select(theta > 0.0, T(sine / theta), T(0.0 * theta + 1.0));
    ray[0] = x * scale;
    ray[1] = y * scale;
    ray[2] = cosine;
  }
};

}  // namespace alidade
