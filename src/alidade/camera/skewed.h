// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Common part of the models that see a lens of the model Base on a sensor whose axes are not at right
/// angles:
///
///   mx = x + skew y,  my = y + shear x
///
/// with (x, y) the map of Base. The parameters of Base come first, then skew and, if kHasShear, shear.
template <class M, class Base, bool kHasShear = false>
struct SkewFormula : LensFormula<M, Base::kNumLensParams + (kHasShear ? 2 : 1)> {
  static constexpr std::size_t kSkew = Base::kNumLensParams;
  static constexpr double kMaxAngle = Base::kMaxAngle;
  static constexpr double kEndMargin = Base::kEndMargin;
  static constexpr bool kIsOneToOneWithoutFold = Base::kIsOneToOneWithoutFold;
  static constexpr LensFamily kFamily = Base::kFamily;
  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = Base::kIsPolynomial;
  static constexpr std::string_view kFlexibleId = "";

  static constexpr std::array<std::string_view, kSkew + (kHasShear ? 2 : 1)> kLensParamNames = [] {
    std::array<std::string_view, kSkew + (kHasShear ? 2 : 1)> names{};
    std::size_t i = 0;
    for (const std::string_view name : Base::kLensParamNames) names[i++] = name;
    names[kSkew] = "skew";
    if constexpr (kHasShear) names[kSkew + 1] = "shear";
    return names;
  }();

  static double maxAngle(const double* k) { return Base::maxAngle(k); }
  static bool isAxiallySymmetric(const double* k) {
    return Base::isAxiallySymmetric(k) && k[kSkew] == 0 && shearOf(k) == 0;
  }
  /// A quarter turn makes skew to shear.
  static bool canTurn(const double* k) { return kHasShear || k[kSkew] == 0; }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    return Base::hasValue(k, ray);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    constexpr std::size_t kAll = M::kNumLensParams;
    T J[2 * kSkew];
    T p[2];
    Base::formula(k, ray, p, J_m_ray, J_m_lens == nullptr ? nullptr : J);
    const auto skewed = [k](const T* from_x, const T* from_y, T* x, T* y, std::size_t count)
                            ALIDADE_INLINE_LAMBDA {
                              for (std::size_t i = 0; i < count; ++i) {
                                const T plain = from_x[i];
                                x[i] = plain + k[kSkew] * from_y[i];
                                y[i] = from_y[i];
                                if constexpr (kHasShear) y[i] = y[i] + k[kSkew + 1] * plain;
                              }
                            };
    skewed(p, p + 1, m, m + 1, 1);
    if (J_m_ray != nullptr) skewed(J_m_ray, J_m_ray + 3, J_m_ray, J_m_ray + 3, 3);
    if (J_m_lens == nullptr) return;
    skewed(J, J + kSkew, J_m_lens, J_m_lens + kAll, kSkew);
    J_m_lens[kSkew] = p[1];
    J_m_lens[kAll + kSkew] = 0.0 * p[1];
    if constexpr (kHasShear) {
      J_m_lens[kSkew + 1] = 0.0 * p[0];
      J_m_lens[kAll + kSkew + 1] = p[0];
    }
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    double p[2];
    plain(k, m, p);
    return Base::unlens(k, p, max_angle, ray);
  }

  using Start = typename Base::Start;
  static Start makeStart(const double* k, double max_angle) { return Base::makeStart(k, max_angle); }
  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m,
                                                double max_angle, T* ray) {
    T p[2];
    plain(k, m, p);
    Base::quickUnlens(k, start, p, max_angle, ray);
  }

 private:
  static double shearOf(const double* k) {
    if constexpr (kHasShear) return k[kSkew + 1];
    return 0.0;
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void plain(const double* k, const T* m, T* p) {
    const double shear = shearOf(k);
    const double scale = 1.0 / (1.0 - k[kSkew] * shear);
    p[0] = (m[0] - k[kSkew] * m[1]) * scale;
    p[1] = (m[1] - shear * m[0]) * scale;
  }
};

}  // namespace alidade
