// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/camera_model.h"

namespace alidade {

/// Pixel of a point of the camera frame by the bare formula; `params` holds fx fy cx cy and the lens. False
/// where the formula has no value. It knows nothing of folds: Camera::project is the one that never returns a
/// wrong pixel.
template <CameraModel M, class T>
bool projectFormula(const T* params, const T* p_cam, T* px) {
  T m[2];
  if (!M::lens(params + 4, p_cam, m)) return false;
  px[0] = params[0] * m[0] + params[2];
  px[1] = params[1] * m[1] + params[3];
  return true;
}

/// The same with row-major Jacobians: J_px_cam is 2x3, J_px_params is 2 x kNumParams<M>; null = not wanted.
template <CameraModel M>
bool projectFormulaJacobian(const double* params, const double* p_cam, double* px, double* J_px_cam,
                            double* J_px_params) {
  constexpr int kLens = M::kNumLensParams;
  constexpr int kAll = kNumParams<M>;
  double m[2];
  double J_m_lens[2 * kLens + 1];
  if (!M::lensJacobian(params + 4, p_cam, m, J_px_cam, J_px_params == nullptr ? nullptr : J_m_lens))
    return false;
  const double fx = params[0];
  const double fy = params[1];
  px[0] = fx * m[0] + params[2];
  px[1] = fy * m[1] + params[3];
  if (J_px_cam != nullptr) {
    for (int i = 0; i < 3; ++i) {
      J_px_cam[i] *= fx;
      J_px_cam[3 + i] *= fy;
    }
  }
  if (J_px_params != nullptr) {
    double* du = J_px_params;
    double* dv = J_px_params + kAll;
    du[0] = m[0];
    du[1] = 0;
    du[2] = 1;
    du[3] = 0;
    dv[0] = 0;
    dv[1] = m[1];
    dv[2] = 0;
    dv[3] = 1;
    for (int i = 0; i < kLens; ++i) {
      du[4 + i] = fx * J_m_lens[i];
      dv[4 + i] = fy * J_m_lens[kLens + i];
    }
  }
  return true;
}

}  // namespace alidade
