// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <numbers>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// How far a certified angle stays below the fold itself, radians. At a fold the inverse loses all digits;
/// this far inside it keeps 1e-9 rad.
inline constexpr double kFoldMargin = 1e-5;

/// The normalised plane's point m[2] and its row-major 2x3 Jacobian by a unit ray; false where the lens has
/// no value (beyond a pole).
using LensJacobianFunction = std::function<bool(const Eigen::Vector3d& ray, double* m, double* J_m_ray)>;

/// The known limits of the domain of a model; see CameraModel.
struct ConeLimits {
  double model_rad = std::numbers::pi;        ///< the model's largest angle, whatever its parameters
  double closed_form_rad = std::numbers::pi;  ///< the same with these parameters
  bool is_axially_symmetric = false;          ///< check only one azimuth
  bool is_one_to_one_without_fold = true;     ///< false: check the rim too
};

/// Finds the smallest field angle, over all azimuths, at which the lens stops being one-to-one: where
/// the determinant of the Jacobian restricted to the unit sphere turns negative (a fold), the lens has
/// no value (a pole), or the determinant is so small that the inverse has lost its digits (almost a
/// fold).
[[nodiscard]] CertifiedCone certifyCone(const LensJacobianFunction& lens, const ConeLimits& limits);

/// Determinant of the lens' Jacobian by the unit sphere's tangent plane at `ray` (unit length), per
/// steradian.
[[nodiscard]] double sphereDeterminant(const double* J_m_ray, const Eigen::Vector3d& ray);

}  // namespace alidade
