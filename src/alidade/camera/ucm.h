// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/eucm.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Unified camera model: central projection through the unit sphere, in the form that separates fx and fy
/// from the shape. With d = sqrt(X^2 + Y^2 + Z^2):
///
///   mx = X / (alpha d + (1 - alpha) Z),  my = Y / (alpha d + (1 - alpha) Z)
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), alpha (0 to 1, no unit). alpha = 0 is the
/// perspective projection, 1/2 the stereographic one. Mei's form has xi = alpha / (1 - alpha) and focal
/// lengths that are 1 + xi times as large. Domain: Z > -w d with w = alpha / (1 - alpha) up to alpha = 1/2
/// (a pole) and w = (1 - alpha) / alpha above (a fold). Inverse: closed form. It is `eucm` with beta = 1
/// and computed as such. Source: Geyer and Daniilidis 2000, A unifying theory for central panoramic
/// systems, ECCV; this form: Usenko, Demmel and Cremers 2018, The double sphere camera model, 3DV, section
/// 2.2.
struct Ucm : LensFormula<Ucm, 1> {
  static constexpr std::string_view kId = "ucm";
  static constexpr std::string_view kAliases = "unified omni-none";
  static constexpr std::array<std::string_view, 1> kLensParamNames = {"alpha"};
  static constexpr std::array<ParamRange, 1> kLensRanges = {ParamRange{.min = 0.0, .max = 1.0}};
  static constexpr std::array<double, 1> kStartLens = {0.5};
  static constexpr double kMaxAngle = kWideMaxAngle;

  static constexpr LensFamily kFamily = LensFamily::kWide;
  static constexpr bool kIsStiff = true;
  static constexpr bool kIsPolynomial = false;
  static constexpr std::string_view kFlexibleId = "kannala_brandt";
  static constexpr std::array<LensVector, 0> kVectors = {};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"pinhole"}};

  static double maxAngle(const double* k) { return Eucm::maxAngle(withBeta(k).data()); }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    return Eucm::hasValue(withBeta(k).data(), ray);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    T J_m_eucm[4];
    Eucm::formula(withBeta(k).data(), ray, m, J_m_ray, J_m_lens == nullptr ? nullptr : J_m_eucm);
    if (J_m_lens != nullptr) {
      J_m_lens[0] = J_m_eucm[0];
      J_m_lens[1] = J_m_eucm[2];
    }
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start&, const T* m, double max_angle,
                                                T* ray) {
    Eucm::quickUnlens(withBeta(k).data(), {}, m, max_angle, ray);
  }

 private:
  template <class T>
  static std::array<T, 2> withBeta(const T* k) {
    return {k[0], T(1)};
  }
};

}  // namespace alidade
