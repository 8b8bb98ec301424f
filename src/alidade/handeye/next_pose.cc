// SPDX-License-Identifier: MIT
#include "alidade/handeye/next_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/degrees.h"

namespace alidade {
namespace {

// Where the camera sees the board from places near one from which it did.
std::vector<SE3> nearbyPoses(const SE3& camera_from_board, const Eigen::Vector3d& middle) {
  constexpr double kTurn = 30 * kRadPerDeg;
  std::vector<SE3> poses;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double turn : {-kTurn, kTurn}) {
      const SO3 R = SO3::exp(turn * Eigen::Vector3d::Unit(axis));
      poses.push_back(SE3(R, middle - R * middle) * camera_from_board);
    }
  }
  for (const double nearer : {-1.0 / 3, 1.0 / 3})
    poses.push_back(SE3(SO3(), nearer * middle) * camera_from_board);
  return poses;
}

// The corners of the board in the image; none unless most of them are.
std::vector<Observation> cornersFrom(const SE3& camera_from_board, const FitCamera& of, const FitBoard& board,
                                     double weight) {
  constexpr double kMost = 0.6;
  const AnyCamera camera = cameraOf(of);
  std::vector<Observation> corners;
  for (int id = 0; id < board.target.numCorners(); ++id) {
    const Eigen::Vector3d p_board = board.target.corner(id);
    const Projection seen = camera.projectPoint(camera_from_board * p_board);
    if (seen.ok() && isInOrNearImage(seen.pixel, of.size))
      corners.push_back({.p_board = p_board,
                         .pixel = seen.pixel,
                         .weight = weight,
                         .id = id,
                         .radius_m = board.target.discRadius()});
  }
  return static_cast<double>(corners.size()) < kMost * board.target.numCorners() ? std::vector<Observation>()
                                                                                 : corners;
}

}  // namespace

double errorAt(const Matrix6d& covariance, const Eigen::Vector3d& point) {
  constexpr double kOneSided95 = 1.6448536269514722;
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -hat(point);
  const Eigen::Matrix3d of_point = J * covariance * J.transpose();
  const double mean = of_point.trace();
  if (!(mean > 0)) return std::numeric_limits<double>::infinity();
  const double freedom = mean * mean / of_point.squaredNorm();
  const double spread = 2 / (9 * freedom);
  return std::sqrt(mean * std::pow(1 - spread + kOneSided95 * std::sqrt(spread), 3));
}

std::optional<NextPose> nextPose(const RobotFit& fit, const HandEyeCalibration& result) {
  constexpr std::size_t kMany = 60;
  constexpr std::size_t kMostTried = 12;  // driven poses
  if (fit.frames.size() > kMany) return std::nullopt;
  const FitCamera& camera = onlyCamera(fit.fit);
  const auto errorOf = [&](const RobotFit& of) {
    const Eigen::MatrixXd covariance = covarianceWith(of, {});
    return errorAt(covariance.block<6, 6>(of.numParams(), of.numParams()), {0, 0, result.board_distance_m});
  };
  std::optional<NextPose> best;
  for (std::size_t f = 0; f < fit.frames.size(); f += (fit.frames.size() + kMostTried - 1) / kMostTried) {
    const FitView& view = fit.fit.views[fit.frames[f].views.front()];
    const FitBoard& board = boardOf(fit.fit, view);
    double weight = 0;
    for (const Observation& corner : view.corners) weight += corner.weight / std::ssize(view.corners);
    const SE3 seen = cameraFromBoard(fit.fit, view);
    for (const SE3& camera_from_board : nearbyPoses(seen, seen * board.target.middle())) {
      std::vector<Observation> corners = cornersFrom(camera_from_board, camera, board, weight);
      if (corners.empty()) continue;
      const SE3 motion =
          fit.mount_from_camera * camera_from_board * fit.world_from_boards[view.board].inverse();
      RobotFit with = fit;
      addView(with.fit, std::numeric_limits<std::size_t>::max(), std::move(corners), camera_from_board,
              view.board);
      with.frames.push_back(
          {.base_from_gripper = fit.camera_on == CameraOn::kHand ? motion.inverse() : motion,
           .views = {with.fit.views.size() - 1}});
      const double error_m = errorOf(with);
      if (!best || error_m < best->error_m)
        best = {.base_from_gripper = with.frames.back().base_from_gripper, .error_m = error_m};
    }
  }
  // In the units of the stated error, which counts how well the robot's noise is known.
  if (best) best->error_m *= result.error_m / errorOf(fit);
  return best;
}

}  // namespace alidade
