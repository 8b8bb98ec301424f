// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/ucm.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// `ucm` with its plane at twice the distance: fx and fy are half of those of `ucm`. A model for the tests.
struct ScaledUcm : LensFormula<ScaledUcm, 1> {
  static constexpr std::string_view kId = "scaled_ucm";
  static constexpr std::array<std::string_view, 1> kLensParamNames = {"alpha"};
  static constexpr std::array<ParamRange, 1> kLensRanges = Ucm::kLensRanges;
  static constexpr std::array<double, 1> kStartLens = Ucm::kStartLens;
  static constexpr double kMaxAngle = kWideMaxAngle;

  static double toUcm(const double* k, double* ucm) {
    ucm[0] = k[0];
    return 2.0;
  }
  static double fromUcm(const double* ucm, double* k) {
    k[0] = ucm[0];
    return 0.5;
  }

  static constexpr LensFamily kFamily = LensFamily::kWide;
  static constexpr bool kIsStiff = true;
  static constexpr bool kIsPolynomial = false;
  static constexpr std::string_view kFlexibleId = "kannala_brandt";
  static constexpr std::array<LensVector, 0> kVectors = {};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"ucm", toUcm, fromUcm}};

  static double maxAngle(const double* k) { return Ucm::maxAngle(k); }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    return Ucm::hasValue(k, ray);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    Ucm::formula(k, ray, m, J_m_ray, J_m_lens);
    for (int i = 0; i < 2; ++i) m[i] = 2.0 * m[i];
    for (int i = 0; J_m_ray != nullptr && i < 6; ++i) J_m_ray[i] = 2.0 * J_m_ray[i];
    for (int i = 0; J_m_lens != nullptr && i < 2; ++i) J_m_lens[i] = 2.0 * J_m_lens[i];
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start&, const T* m, double max_angle,
                                                T* ray) {
    const T half[2] = {0.5 * m[0], 0.5 * m[1]};
    Ucm::quickUnlens(k, {}, half, max_angle, ray);
  }
};

}  // namespace alidade
