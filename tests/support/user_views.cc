// SPDX-License-Identifier: MIT
#include "support/user_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "alidade/geometry/decompositions.h"
#include "alidade/simulate/observe.h"

namespace alidade {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

double angleFromAxis(const Eigen::Vector3d& p) {
  return std::atan2(p.head<2>().norm(), p.z());
}

// One attempt; the pose of a board whose middle appears at a random pixel.
bool drawPose(const DrawnCamera& drawn, const Checkerboard& board, Random& random, SE3& camera_from_board) {
  const double x = random.uniform(0, drawn.size.width - 1);
  const double y = random.uniform(0, drawn.size.height - 1);
  const double tilt = kRadPerDeg * random.uniform(20, 50);
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const double roll = kRadPerDeg * random.uniform(-30, 30);
  const double fill = random.uniform(0.25, 0.8);
  const auto ray = drawn.camera.unproject({x, y});
  if (!ray || angleFromAxis(*ray) > drawn.rim_rad) return false;
  // Pixels a radian at the axis would do as well; the angle of half the longer side suits every lens.
  const double half_x = 0.5 * (drawn.size.width - 1);
  const double half_y = 0.5 * (drawn.size.height - 1);
  const auto border = drawn.size.width > drawn.size.height ? drawn.camera.unproject({0.0, half_y})
                                                           : drawn.camera.unproject({half_x, 0.0});
  const double half_field =
      std::min({border ? angleFromAxis(*border) : drawn.rim_rad, drawn.rim_rad, kRadPerDeg * 65});
  const Eigen::Vector3d middle = board.middle();
  const double distance = middle.x() / std::tan(fill * half_field);
  const SO3 facing = SO3::fromQuaternion(shortestTurn(Eigen::Vector3d::UnitZ(), *ray));
  camera_from_board.rotation = facing *
                               SO3::exp(tilt * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0)) *
                               SO3::exp({0, 0, roll});
  camera_from_board.translation = distance * *ray - camera_from_board.rotation * middle;
  return true;
}

}  // namespace

UserSet drawUserViews(const DrawnCamera& drawn, int count, double noise_px, Random& random) {
  UserSet set{.board = {.columns = 9, .rows = 6, .square_m = 0.03}, .poses = {}, .views = {}};
  while (static_cast<int>(set.views.size()) < count) {
    SE3 pose;
    if (!drawPose(drawn, set.board, random, pose)) continue;
    View view =
        exactView(drawn.camera, drawn.size, set.board, pose, "view_" + std::to_string(set.views.size()));
    std::erase_if(view.corners, [&](const Corner& corner) {
      return angleFromAxis(pose * set.board.corner(corner.id)) > drawn.rim_rad;
    });
    constexpr std::size_t kFewestCorners = 18;  // a third of 54
    if (view.corners.size() < kFewestCorners) continue;
    addCornerNoise(view, noise_px, random);
    set.poses.push_back(pose);
    set.views.push_back(std::move(view));
  }
  return set;
}

}  // namespace alidade
