// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Perspective projection without distortion: mx = X / Z, my = Y / Z.
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels). Domain: Z > 0. Inverse: closed form.
/// Source: Hartley and Zisserman, Multiple View Geometry, 2nd ed., section 6.1.
struct Pinhole : LensFormula<Pinhole, 0> {
  static constexpr std::string_view kId = "pinhole";
  static constexpr std::string_view kAliases = "perspective simple_pinhole pinhole-none";
  static constexpr std::array<std::string_view, 0> kLensParamNames = {};
  static constexpr double kMaxAngle = std::numbers::pi / 2;

  static constexpr LensFamily kFamily = LensFamily::kPerspective;
  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = false;
  static constexpr std::string_view kFlexibleId = "rational";
  static constexpr std::array<LensVector, 0> kVectors = {};
  static constexpr std::array<SharedLens, 0> kSharedLenses = {};

  template <class T>
  static bool hasValue(const T*, const T* ray) {
    return ray[2] > 0.0;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K*, const T* ray, T* m, T* J_m_ray, T*) {
    const T iz = 1.0 / ray[2];
    m[0] = ray[0] * iz;
    m[1] = ray[1] * iz;
    if (J_m_ray != nullptr) {
      const T zero = 0.0 * iz;
      J_m_ray[0] = iz;
      J_m_ray[1] = zero;
      J_m_ray[2] = -m[0] * iz;
      J_m_ray[3] = zero;
      J_m_ray[4] = iz;
      J_m_ray[5] = -m[1] * iz;
    }
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double*, const Start&, const T* m, double, T* ray) {
    const T z = 1.0 / lane::squareRoot(T(m[0] * m[0] + m[1] * m[1] + 1.0));
    ray[0] = m[0] * z;
    ray[1] = m[1] * z;
    ray[2] = z;
  }
};

}  // namespace alidade
