// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A point of known position and its pixel.
struct KnownPoint {
  Eigen::Vector4d point;  ///< homogeneous, of length 1, in the world
  Eigen::Vector2d pixel;
  double sigma_px = 1;
};

/// The poses camera_from_world that map three points to three unit rays, up to four: Grunert's quartic, in
/// the form of Haralick et al. 1994, Review and analysis of solutions of the three point perspective pose
/// estimation problem, IJCV 13(3), equations 7 to 9.
[[nodiscard]] std::vector<SE3> threePointPoses(const std::array<Eigen::Vector3d, 3>& points,
                                               const std::array<Eigen::Vector3d, 3>& rays);

/// Distance of a pixel from the projection of a homogeneous point; infinite if that has no pixel.
[[nodiscard]] double errorOf(const AnyCamera& camera, const SE3& camera_from_world,
                             const Eigen::Vector4d& point, const Eigen::Vector2d& pixel);

struct Resection {
  SE3 camera_from_world;
  std::vector<bool> is_inlier;  ///< one per point
  std::size_t num_inliers = 0;
};

/// Refines a pose by minimising the reprojection error: Gauss-Newton steps with weights that fall with each
/// error's size (Geman and McClure's function with the scale `threshold_px`).
/// @returns nothing if fewer than 8 points agree within the threshold
[[nodiscard]] std::optional<Resection> refinedPose(const AnyCamera& camera,
                                                   std::span<const KnownPoint> points, const SE3& guess,
                                                   double threshold_px);

/// The pose of a camera from points: a refinement of the guess if more than half of the points agree with it,
/// otherwise of the best three-point pose of random samples.
[[nodiscard]] std::optional<Resection> resect(const AnyCamera& camera, std::span<const KnownPoint> points,
                                              const std::optional<SE3>& guess, double threshold_px,
                                              std::uint64_t seed);

}  // namespace alidade
