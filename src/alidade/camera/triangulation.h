// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_rig.h"

namespace alidade {

/// A pixel at which a camera of a rig sees a point.
struct RigPixel {
  std::size_t camera = 0;  ///< index into AnyRig::cameras()
  Eigen::Vector2d pixel{0, 0};
  double sigma_px = 1;  ///< standard deviation of each coordinate, positive
};

/// Outcome of a triangulation: a point, or the reason why there is none.
enum class TriangulationStatus : std::uint8_t {
  kOk,
  kTooFewCameras,  ///< fewer than two different cameras
  kNoRay,          ///< no ray projects to one of the pixels
  kAtInfinity,     ///< the rays are parallel, or diverge by no more than three standard deviations
  kBehind,         ///< the rays diverge by more, or meet behind a camera: they show different points
  kUndetermined,   ///< the point may lie anywhere on a line: cameras at one place, or rays along the line
                   ///< through them
  kNotConverged,
};

/// "ok", "too_few_cameras", "no_ray", "at_infinity", "behind", "undetermined", "not_converged".
[[nodiscard]] std::string_view statusId(TriangulationStatus status);

/// A point from its pixels. All numbers are NaN, and `residuals` empty, unless the status is kOk.
struct Triangulation {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  TriangulationStatus status = TriangulationStatus::kNotConverged;
  Eigen::Vector3d p_rig = Eigen::Vector3d::Constant(kNone);  ///< in the rig's frame, metres
  /// sqrt(mean over pixels of dx^2 + dy^2).
  double error_px = kNone;
  std::vector<Eigen::Vector2d> residuals;  ///< projected minus given, in the order of the pixels
  /// The part of the covariance that comes from the noise of the pixels, m^2.
  Eigen::Matrix3d covariance_by_pixels = Eigen::Matrix3d::Constant(kNone);
  /// The part that comes from the uncertainty of the rig; zero if that is unknown. Points of one rig share
  /// it: it does not average out over many points.
  Eigen::Matrix3d covariance_by_rig = Eigen::Matrix3d::Constant(kNone);

  [[nodiscard]] bool ok() const { return status == TriangulationStatus::kOk; }
  [[nodiscard]] Eigen::Matrix3d covariance() const { return covariance_by_pixels + covariance_by_rig; }
};

/// The point that minimises the sum of the squared pixel errors, each divided by its sigma_px, found by
/// Levenberg-Marquardt from the linear solution for the rays. It works in direction and inverse distance, so
/// that points near infinity are no special case.
///
/// The covariances are those of first order by the implicit function theorem, without the second derivatives
/// of the projection. They describe the point as long as its distance is well above its standard deviation.
///
///
/// @param rig_covariance  joint covariance of the parameters of each camera in storage order, then of the
/// tangent [translation, rotation] of camera_from_rig of each camera but the first, as a right perturbation
/// (RigRecord::covariance); 0 x 0: unknown
/// @pre the cameras of the pixels exist; rig_covariance has a row for each of these unknowns
[[nodiscard]] Triangulation triangulate(const AnyRig& rig, std::span<const RigPixel> pixels,
                                        const Eigen::MatrixXd& rig_covariance = Eigen::MatrixXd());

/// How far the pixels of one point lie from each other's epipolar curves, px: the RMS of the distances in
/// both images, to first order. In rectified images of the same scale, it is the difference of their rows.
/// Nothing if a pixel has no ray, or if a ray points at the other camera.
[[nodiscard]] std::optional<double> epipolarDistance(const MountedCamera& a, const MountedCamera& b,
                                                     const Eigen::Vector2d& pixel_a,
                                                     const Eigen::Vector2d& pixel_b);

/// Number of rows of the joint covariance of a rig.
[[nodiscard]] Eigen::Index numRigUnknowns(const AnyRig& rig);

}  // namespace alidade
