// SPDX-License-Identifier: MIT
#include "alidade/init/pose_from_homography.h"

#include <cmath>
#include <vector>

#include <Eigen/SVD>

#include "alidade/init/homography.h"

namespace alidade {

std::optional<SE3> poseFromHomography(const Eigen::Matrix3d& plane_from_board) {
  Eigen::Matrix3d H = plane_from_board;
  // The board is in front of the camera: its origin has positive depth.
  if (H(2, 2) < 0) H = -H;
  const double scale = 2.0 / (H.col(0).norm() + H.col(1).norm());
  if (!std::isfinite(scale)) return std::nullopt;
  Eigen::Matrix3d axes;
  axes << scale * H.col(0), scale * H.col(1), (scale * H.col(0)).cross(scale * H.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  const Eigen::Vector3d t = scale * H.col(2);
  if (!R.allFinite() || R.determinant() < 0 || !(t.z() > 0)) return std::nullopt;
  SE3 camera_from_board;
  camera_from_board.rotation = SO3::fromQuaternion(Eigen::Quaterniond(R));
  camera_from_board.translation = t;
  return camera_from_board;
}

std::optional<SE3> poseFromView(const AnyCamera& camera, const Checkerboard& board,
                                std::span<const Corner> corners) {
  // Rays near 90 degrees from the axis leave the plane z = 1; the rest determines the pose.
  constexpr double kMinDepth = 0.05;
  std::vector<Eigen::Vector2d> on_board;
  std::vector<Eigen::Vector2d> on_plane;
  for (const Corner& corner : corners) {
    const auto ray = camera.unproject(corner.pixel);
    if (!ray || ray->z() < kMinDepth) continue;
    on_board.emplace_back(board.corner(corner.id).head<2>());
    on_plane.emplace_back(ray->hnormalized());
  }
  const auto H = fitHomography(on_board, on_plane);
  if (!H) return std::nullopt;
  return poseFromHomography(*H);
}

}  // namespace alidade
