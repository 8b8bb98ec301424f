// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <numbers>

#include "alidade/camera/project_status.h"

namespace alidade {

/// Distance of a certified angle from the fold itself, radians. At a fold, the inverse loses all digits; this
/// far inside, it keeps 1e-9 rad.
inline constexpr double kFoldMargin = 1e-5;

/// Unit rays, their points in the normalised plane and the row-major 2x3 Jacobians between them, stored by
/// coordinate so that loops over the rays vectorise. m is NaN where the lens has no value (beyond a pole).
struct LensBlock {
  static constexpr std::size_t kMaxRays = 8;
  using Column = std::array<double, kMaxRays>;
  std::array<Column, 3> ray;
  std::array<Column, 2> m;
  std::array<Column, 6> J_m_ray;
};

/// Fills m and J_m_ray of the first `count` rays.
using LensFunction = std::function<void(LensBlock& block, std::size_t count)>;

/// The lens of a model with the parameters `lens`, which must outlive the function.
template <class M>
[[nodiscard]] LensFunction lensFunction(const double* lens) {
  return [lens](LensBlock& block, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const double ray[3] = {block.ray[0][i], block.ray[1][i], block.ray[2][i]};
      double m[2];
      double J[6];
      double* const not_wanted = nullptr;
      M::formula(lens, ray, m, J, not_wanted);
      block.m[0][i] = M::hasValue(lens, ray) ? m[0] : std::numeric_limits<double>::quiet_NaN();
      block.m[1][i] = m[1];
      for (std::size_t e = 0; e < 6; ++e) block.J_m_ray[e][i] = J[e];
    }
  };
}

/// The known limits of the domain of a model; see CameraModel.
struct ConeLimits {
  double model_rad = std::numbers::pi;        ///< the model's largest angle, regardless of its parameters
  double closed_form_rad = std::numbers::pi;  ///< the same with these parameters
  bool is_axially_symmetric = false;          ///< check only one azimuth
  bool is_one_to_one_without_fold = true;     ///< false: check the rim too
  double margin_rad = kFoldMargin;            ///< from a fold to the rim
};

/// Finds the smallest field angle, over all azimuths, at which the lens stops being one-to-one: where the
/// determinant of the Jacobian restricted to the unit sphere turns negative (a fold), the lens has no value
/// (a pole), or the determinant is so small that the inverse loses its digits (a near fold).
[[nodiscard]] CertifiedCone certifyCone(const LensFunction& lens, const ConeLimits& limits);

}  // namespace alidade
