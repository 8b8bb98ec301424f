// SPDX-License-Identifier: MIT
#include "alidade/guide/board_sighting.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

using RayJacobian = Eigen::Matrix<double, 3, 2, Eigen::RowMajor>;

// Logarithm of the solid angle that a pixel sees, or nothing without a ray.
std::optional<double> logSolidAngle(const AnyCamera& camera, const Eigen::Vector2d& pixel) {
  RayJacobian J;
  if (!camera.unproject(pixel, J.data())) return std::nullopt;
  return std::log(J.col(0).cross(J.col(1)).norm());
}

// Its derivative by the pixel; zero along an axis along which a neighbour has no ray.
Eigen::Vector2d solidAngleSlope(const AnyCamera& camera, const Eigen::Vector2d& pixel) {
  Eigen::Vector2d slope(0, 0);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = Eigen::Vector2d::Unit(axis);
    const auto before = logSolidAngle(camera, pixel - step);
    const auto behind = logSolidAngle(camera, pixel + step);
    if (before && behind) slope(axis) = 0.5 * (*behind - *before);
  }
  return slope;
}

// The facing pose, upright in the image: where the lens' own is not known. A ray that is none has no pose,
// and any will do.
SO3 facingPose(const Eigen::Vector3d& ray) {
  if (!ray.allFinite()) return {};
  return SO3::fromQuaternion(shortestTurn(Eigen::Vector3d::UnitZ(), ray));
}

}  // namespace

double BoardTilt::total() const {
  return std::atan(std::hypot(std::tan(right_rad), std::tan(lower_rad)));
}

std::optional<SO3> squarePose(const AnyCamera& camera, const Eigen::Vector2d& pixel) {
  RayJacobian J;
  const auto ray = camera.unproject(pixel, J.data());
  if (!ray) return std::nullopt;
  // A pixel of solid angle w sees the area w s^2 / cos(a) of a plane at the distance s = c / (n ray) along
  // its ray, with the cosine of the angle to the normal n: n ray. The area is stationary, so that no side
  // appears larger, where 3 n J = (n ray) slope of log w. With n ray = 1 that gives n's part across the ray.
  const Eigen::Vector2d slope = solidAngleSlope(camera, pixel);
  const Eigen::Matrix2d gram = J.transpose() * J;
  Eigen::Vector3d across = J * (gram.inverse() * slope) / 3;
  // Near the rim of its domain a lens may compress so much that it would show only a board seen from its edge
  // as square; nobody finds corners on that.
  constexpr double kMaxTan = 1.7320508075688772;  // 60 degrees between the square pose and the facing one
  const double tan = across.norm();
  if (!std::isfinite(tan)) return facingPose(*ray);  // at a fold
  if (tan > kMaxTan) across *= kMaxTan / tan;
  const Eigen::Vector3d n = (*ray + across).normalized();
  const Eigen::Vector3d right = J.col(0) - *ray * (n.dot(J.col(0)) / n.dot(*ray));  // along the plane
  if (!right.allFinite() || right.isZero(0)) return facingPose(*ray);
  Eigen::Matrix3d R;
  R.col(2) = n;
  R.col(0) = right.normalized();
  R.col(1) = n.cross(R.col(0));
  return SO3::fromQuaternion(Eigen::Quaterniond(R));
}

BoardSighting sightBoard(const AnyCamera& camera, const Checkerboard& board, const SE3& camera_from_board) {
  BoardSighting sighting;
  const Eigen::Vector3d middle = camera_from_board * board.middle();
  sighting.middle_px = camera.project(middle).pixel;
  sighting.distance_m = middle.norm();
  const auto square = squarePose(camera, sighting.middle_px);
  const SO3 camera_from_square = square ? *square : facingPose(middle.normalized());
  const Eigen::Vector3d n =
      camera_from_square.inverse() * (camera_from_board.rotation * Eigen::Vector3d::UnitZ());
  sighting.tilt = {.right_rad = std::atan2(n.x(), n.z()), .lower_rad = std::atan2(n.y(), n.z())};
  return sighting;
}

SO3 tiltedBoard(const BoardTilt& tilt) {
  // The shortest way from the square pose keeps the board upright in the image. A normal that leans to the
  // right brings the right side nearer.
  return facingPose(Eigen::Vector3d(std::tan(tilt.right_rad), std::tan(tilt.lower_rad), 1).normalized());
}

std::string tiltText(const BoardTilt& tilt) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  constexpr double kLeastDegrees = 5;
  const double across = kDegrees * std::abs(tilt.right_rad);
  const double along = kDegrees * std::abs(tilt.lower_rad);
  const bool is_across = across >= kLeastDegrees;
  const bool is_along = along >= kLeastDegrees;
  if (!is_across && !is_along) return "not tilted";
  const char* side = tilt.right_rad > 0 ? "right" : "left";
  const char* end = tilt.lower_rad > 0 ? "lower" : "upper";
  if (!is_along) return fmt::format("its {} side turned {:.0f} degrees towards the camera", side, across);
  if (!is_across) return fmt::format("its {} side turned {:.0f} degrees towards the camera", end, along);
  return fmt::format("its {} side turned {:.0f} degrees and its {} side {:.0f} degrees towards the camera",
                     side, across, end, along);
}

}  // namespace alidade
