// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "alidade/camera/camera_model.h"

namespace alidade {

/// Perspective projection without distortion: mx = X / Z, my = Y / Z.
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels). Domain: Z > 0. Inverse: closed form.
/// Source: Hartley and Zisserman, Multiple View Geometry, 2nd ed., section 6.1.
struct Pinhole {
  static constexpr std::string_view kId = "pinhole";
  static constexpr int kNumLensParams = 0;
  static constexpr std::array<std::string_view, 0> kLensParamNames = {};
  static constexpr std::array<ParamRange, 0> kLensRanges = {};
  static constexpr std::array<double, 0> kStartLens = {};
  static constexpr double kMaxAngle = std::numbers::pi / 2;
  static constexpr bool kIsOneToOneWithoutFold = true;

  static double maxAngle(const double*) { return kMaxAngle; }
  static bool isAxiallySymmetric(const double*) { return true; }

  template <class T>
  static bool lens(const T*, const T* ray, T* m) {
    if (!(ray[2] > T(0))) return false;
    m[0] = ray[0] / ray[2];
    m[1] = ray[1] / ray[2];
    return true;
  }

  static bool lensJacobian(const double*, const double* ray, double* m, double* J_m_ray, double*) {
    if (!(ray[2] > 0.0)) return false;
    const double iz = 1.0 / ray[2];
    m[0] = ray[0] * iz;
    m[1] = ray[1] * iz;
    if (J_m_ray != nullptr) {
      J_m_ray[0] = iz;
      J_m_ray[1] = 0.0;
      J_m_ray[2] = -m[0] * iz;
      J_m_ray[3] = 0.0;
      J_m_ray[4] = iz;
      J_m_ray[5] = -m[1] * iz;
    }
    return true;
  }

  static bool unlens(const double*, const double* m, double, double* ray) {
    const double norm = std::hypot(m[0], m[1], 1.0);
    if (!std::isfinite(norm)) return false;
    ray[0] = m[0] / norm;
    ray[1] = m[1] / norm;
    ray[2] = 1.0 / norm;
    return true;
  }
};

}  // namespace alidade
