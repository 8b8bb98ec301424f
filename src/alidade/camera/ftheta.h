// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "alidade/camera/angle_polynomial.h"
#include "alidade/camera/camera_model.h"
#include "alidade/camera/ftheta_inverse.h"
#include "alidade/camera/stated_inverse.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Fisheye lenses as a polynomial of all powers of the field angle. With rho = sqrt(X^2 + Y^2) and
/// theta = atan2(rho, Z):
///
///   r  = theta (1 + k1 theta + k2 theta^2 + k3 theta^3 + k4 theta^4 + k5 theta^5)
///   mx = r X / rho,  my = r Y / rho
///
/// Parameters: fx, fy (pixels per radian on the axis, > 0), cx, cy (pixels), k1 to k5 (no unit). WoodScape's
/// radial_poly and NVIDIA's fw_poly, in pixels, are fx, fx k1, fx k2, ... Domain and inverse: as
/// `kannala_brandt`. Source: Yogamani et al. 2019, WoodScape: a multi-task, multi-camera fisheye dataset for
/// autonomous driving, ICCV, section 2; NVIDIA DriveWorks, FTheta camera model with POLYNOMIAL_TYPE
/// ANGLE_TO_PIXELDISTANCE.
struct FTheta : AnglePolynomial<FTheta, RadialFormula<FTheta, 5>> {
  static constexpr std::string_view kId = "ftheta";
  static constexpr std::string_view kAliases = "f_theta radial_poly fw_poly";
  static constexpr bool kIsCandidate = false;
  static constexpr std::array<std::string_view, 5> kLensParamNames = {"k1", "k2", "k3", "k4", "k5"};
  static constexpr bool kIsPolynomial = true;
  static constexpr std::array<SharedLens, 0> kSharedLenses = {};

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RisingValue<T> radiusOf(const K* k, const T& theta) {
    return FThetaInverse::angleOf(k, theta);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialImage<T> image(const K* k, const T& rho2, const T& z,
                                                            T* by_lens) {
    const T rho = lane::squareRoot(T(rho2 + detail::kTinySine2 * (rho2 + z * z)));
    const T theta = rho * detail::angleOverRadius(rho2, z);
    const detail::RisingValue<T> r = radiusOf(k, theta);
    if (by_lens != nullptr) {
      T power = theta / rho;
      for (int i = 0; i < 5; ++i) by_lens[i] = power = power * theta;
    }
    return {r.value / rho, r.slope};
  }
};

}  // namespace alidade
