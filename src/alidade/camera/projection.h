// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "alidade/camera/camera_model.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Pixel of a point of the camera frame where the formula has a value, for double or Lanes, with row-major
/// Jacobians: J_px_cam is 2x3, J_px_params is 2 x kNumParams<M>; null: not computed. `params` holds fx fy cx
/// cy and the lens. It does not check for folds; Camera::project never returns a wrong pixel.
template <CameraModel M, class T>
ALIDADE_ALWAYS_INLINE void projectInside(const double* params, const T* p_cam, T* px, T* J_px_cam,
                                         T* J_px_params) {
  constexpr int kLens = M::kNumLensParams;
  constexpr int kAll = kNumParams<M>;
  T m[2];
  T J_m_lens[2 * kLens + 1];
  M::formula(params + 4, p_cam, m, J_px_cam, J_px_params == nullptr ? nullptr : J_m_lens);
  const double fx = params[0];
  const double fy = params[1];
  px[0] = fx * m[0] + params[2];
  px[1] = fy * m[1] + params[3];
  if (J_px_cam != nullptr) {
    for (int i = 0; i < 3; ++i) {
      J_px_cam[i] = fx * J_px_cam[i];
      J_px_cam[3 + i] = fy * J_px_cam[3 + i];
    }
  }
  if (J_px_params != nullptr) {
    T* du = J_px_params;
    T* dv = J_px_params + kAll;
    const T zero = {};
    const T one = zero + 1.0;
    du[0] = m[0];
    du[1] = zero;
    du[2] = one;
    du[3] = zero;
    dv[0] = zero;
    dv[1] = m[1];
    dv[2] = zero;
    dv[3] = one;
    for (int i = 0; i < kLens; ++i) {
      du[4 + i] = fx * J_m_lens[i];
      dv[4 + i] = fy * J_m_lens[kLens + i];
    }
  }
}

/// projectInside(); false if the formula has no value.
template <CameraModel M>
bool projectFormulaJacobian(const double* params, const double* p_cam, double* px, double* J_px_cam,
                            double* J_px_params) {
  if (!M::hasValue(params + 4, p_cam)) return false;
  projectInside<M>(params, p_cam, px, J_px_cam, J_px_params);
  return std::isfinite(px[0]) && std::isfinite(px[1]);
}

/// Row-major 3x2 Jacobian of a pixel's unit ray by the pixel, at the ray. The rows a, b of the lens Jacobian
/// are normal to the ray r, because the lens does not depend on its length. The inverse on the tangent plane
/// of the unit sphere has the columns b x r and r x a, divided by (a x b) r.
template <CameraModel M, class T>
ALIDADE_ALWAYS_INLINE void rayByPixel(const double* params, const T* ray, T* J_ray_pixel) {
  T m[2];
  T J[6];
  T* const not_wanted = nullptr;
  M::formula(params + 4, ray, m, J, not_wanted);
  const T* a = J;
  const T* b = J + 3;
  const T det = (a[1] * b[2] - a[2] * b[1]) * ray[0] + (a[2] * b[0] - a[0] * b[2]) * ray[1] +
                (a[0] * b[1] - a[1] * b[0]) * ray[2];
  const T by_u = 1.0 / (params[0] * det);
  const T by_v = 1.0 / (params[1] * det);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int l = (i + 2) % 3;
    J_ray_pixel[2 * i] = by_u * (b[j] * ray[l] - b[l] * ray[j]);
    J_ray_pixel[2 * i + 1] = by_v * (ray[j] * a[l] - ray[l] * a[j]);
  }
}

}  // namespace alidade
