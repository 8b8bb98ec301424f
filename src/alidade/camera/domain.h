// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <numbers>

#include <Eigen/Core>

namespace alidade {

/// How far a certified angle stays below the fold itself, radians. At a fold the inverse loses all digits;
/// this far inside it keeps 1e-9 rad.
inline constexpr double kFoldMargin = 1e-5;

/// The cone about the optical axis in which a camera is one-to-one.
struct CertifiedCone {
  double max_angle_rad = std::numbers::pi;  ///< largest field angle that may be used
  bool is_limited_by_fold = false;          ///< false: the model's own limit, no fold or pole below it
};

/// Row-major 2x3 Jacobian of the normalised plane by a unit ray; false where the lens has no value (a pole).
using LensJacobianFunction = std::function<bool(const Eigen::Vector3d& ray, double* J_m_ray)>;

/// Finds the smallest field angle, over all azimuths, at which the lens stops being locally one-to-one: where
/// the determinant of the Jacobian restricted to the unit sphere turns negative, or the lens has no value.
/// @param limit_rad  the model's own largest angle
/// @param is_axially_symmetric  look at one azimuth only
[[nodiscard]] CertifiedCone certifyCone(const LensJacobianFunction& lens, double limit_rad,
                                        bool is_axially_symmetric);

/// Determinant of the lens' Jacobian by the unit sphere's tangent plane at `ray` (unit length), per
/// steradian.
[[nodiscard]] double sphereDeterminant(const double* J_m_ray, const Eigen::Vector3d& ray);

}  // namespace alidade
