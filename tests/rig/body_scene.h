// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "rig_scene.h"

namespace alidade {

/// Cameras that never see one board at the same time, and boards that are fixed to each other.
struct BodyRig {
  std::vector<TrueCamera> cameras;
  std::vector<Board> boards;
  std::vector<SE3> body_from_board;
  std::size_t num_together = 1;                 ///< cameras that see the same boards, which others do not
  SE3 rig_from_body = {};                       ///< about which the rig, or the body, moves
  Eigen::Vector3d turns_rad = {0.4, 0.4, 0.4};  ///< largest, about the axes of the rig
  Eigen::Vector3d steps_m = {0.25, 0.25, 0.25};
  int num_own = 0;  ///< images of each camera alone, of the last board, which is held by hand
};

inline SE3 turnedAbout(const Eigen::Vector3d& axis, double degrees,
                       const Eigen::Vector3d& translation = {0, 0, 0}) {
  return {SO3::exp(degrees * std::numbers::pi / 180 * axis), translation};
}

/// A camera at a place in the rig that looks along +z turned about the y axis.
inline SE3 cameraAt(const Eigen::Vector3d& p_rig, double yaw_degrees) {
  return turnedAbout(Eigen::Vector3d::UnitY(), yaw_degrees, p_rig).inverse();
}

/// The place of a board whose middle a camera sees head-on at this distance.
inline SE3 boardBefore(const TrueCamera& camera, const Board& board, double distance_m) {
  const SE3 camera_from_board(SO3(), Eigen::Vector3d(0, 0, distance_m) - board.middle());
  return camera.camera_from_rig.inverse() * camera_from_board;
}

inline Board wallBoard(double square_m) {
  return CharucoBoard{.columns = 11,
                      .rows = 8,
                      .square_m = square_m,
                      .marker_m = 0.75 * square_m,
                      .dictionary = "DICT_4X4_250"};
}

inline TrueCamera radtanAt(const SE3& camera_from_rig) {
  const std::vector<double> params = {900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0};
  return {AnyCamera::make("radtan", params), {1280, 960}, camera_from_rig};
}

inline TrueCamera fisheyeAt(const SE3& camera_from_rig) {
  const std::vector<double> params = {630, 631, 960, 718, 0.01, -0.003, 0.001, 0};
  return {AnyCamera::make("kannala_brandt", params), {1920, 1440}, camera_from_rig};
}

/// Three boards before a camera: one in the middle, two beside it, turned towards the camera.
inline void addWall(const TrueCamera& camera, double square_m, double distance_m, double aside_degrees,
                    BodyRig& rig) {
  for (const int side : {-1, 0, 1}) {
    const SE3 around = turnedAbout(Eigen::Vector3d::UnitY(), side * aside_degrees);
    const SE3 tilted = turnedAbout(Eigen::Vector3d(0.5 * side, side, 0.3).normalized(), 25);
    const Board board = wallBoard(square_m);
    const SE3 at_middle(SO3(), -board.middle());
    const SE3 before(SO3(), Eigen::Vector3d(0, 0, distance_m));
    rig.boards.push_back(board);
    rig.body_from_board.push_back(camera.camera_from_rig.inverse() * around * before *
                                  (side == 0 ? SE3() : tilted) * at_middle);
  }
}

/// Two cameras back to back in a room.
inline BodyRig facingApart() {
  BodyRig rig{.cameras = {radtanAt({}), radtanAt(cameraAt({0.05, 0.02, -0.1}, 180))},
              .boards = {},
              .body_from_board = {}};
  for (const TrueCamera& camera : rig.cameras) addWall(camera, 0.07, 2, 22, rig);
  rig.turns_rad = {0.4, 0.4, 0.8};
  rig.boards.push_back(wallBoard(0.03));
  rig.num_own = 20;
  return rig;
}

/// Six cameras around a post, each before boards of its own.
inline BodyRig ringOfSix() {
  BodyRig rig;
  for (int c = 0; c < 6; ++c) {
    const double yaw = 60 * c;
    const Eigen::Vector3d out =
        turnedAbout(Eigen::Vector3d::UnitY(), yaw).rotation * Eigen::Vector3d(0, 0, 0.1);
    const std::vector<double> params = {1180, 1182, 640, 478, -0.2, 0.06, 2e-4, -3e-4, 0};
    rig.cameras.push_back({AnyCamera::make("radtan", params), {1280, 960}, cameraAt(out, yaw)});
    addWall(rig.cameras.back(), 0.05, 2, 17, rig);
  }
  rig.turns_rad = {0.3, 0.3, 0.6};
  return rig;
}

/// Fisheyes at the four sides of a car that drives over ramps between boards.
inline BodyRig carSurround() {
  BodyRig rig;
  const Eigen::Vector3d places[] = {{0, 0, 2}, {0.95, -0.2, 0.4}, {0, -0.1, -2}, {-0.95, -0.2, 0.4}};
  for (int c = 0; c < 4; ++c) {
    rig.cameras.push_back(fisheyeAt(cameraAt(places[c], 90 * c)));
    addWall(rig.cameras.back(), 0.1, 2, 30, rig);
  }
  rig.turns_rad = {0.12, 0.5, 0.12};
  rig.steps_m = {0.4, 0.1, 0.4};
  return rig;
}

/// Two stereo pairs back to back.
inline BodyRig twoPairs() {
  BodyRig rig{.cameras = {radtanAt({}), radtanAt(cameraAt({0.15, 0, 0}, -2)),
                          radtanAt(cameraAt({0.1, 0, -0.1}, 180)), radtanAt(cameraAt({-0.05, 0, -0.1}, 182))},
              .boards = {},
              .body_from_board = {},
              .num_together = 2};
  for (const std::size_t c : {0U, 2U}) addWall(rig.cameras[c], 0.06, 2, 22, rig);
  return rig;
}

/// Four fixed cameras around a box with two boards on each of its sides, tilted like a roof.
inline BodyRig aroundBody() {
  BodyRig rig;
  for (int c = 0; c < 4; ++c) {
    const double yaw = 90 * c;
    const SE3 out = turnedAbout(Eigen::Vector3d::UnitY(), yaw);
    rig.cameras.push_back(radtanAt(cameraAt(out.rotation * Eigen::Vector3d(0, 0, -2.4), yaw)));
    for (const int side : {-1, 1}) {
      const Board board = wallBoard(0.07);
      const SE3 at_middle(SO3(), -board.middle());
      const SE3 before = turnedAbout(Eigen::Vector3d::UnitX(), 25 * side, {0, 0.35 * side, 2});
      rig.boards.push_back(board);
      rig.body_from_board.push_back(rig.cameras.back().camera_from_rig.inverse() * before * at_middle);
    }
  }
  rig.turns_rad = {0.4, 0.4, 0.8};
  rig.steps_m = {0.6, 0.6, 0.6};
  rig.boards.push_back(wallBoard(0.03));
  rig.num_own = 20;
  return rig;
}

/// The views of a rig that moves relative to the body. Its first camera need not be at the origin.
inline RigScene sceneOf(const BodyRig& rig, int num_frames, double noise_px, std::uint64_t seed) {
  Random random(seed);
  RigScene scene{.cameras = rig.cameras, .views = {}};
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    scene.views.push_back({.name = "camera" + std::to_string(c), .views = {}});
  const auto upTo = [&](const Eigen::Vector3d& most) {
    return Eigen::Vector3d(random.uniform(-most.x(), most.x()), random.uniform(-most.y(), most.y()),
                           random.uniform(-most.z(), most.z()));
  };
  const auto addView = [&](std::size_t b, const SE3& camera_from_board, const std::string& image,
                           RigViews& to) {
    const TrueCamera& camera = rig.cameras[static_cast<std::size_t>(&to - scene.views.data())];
    View view = exactView(camera.camera, camera.size, rig.boards[b], camera_from_board, image + ".png");
    if (view.corners.size() < 20) return;
    addCornerNoise(view, noise_px, random);
    view.board = b;
    for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
    std::erase_if(view.corners,
                  [&](const Corner& corner) { return !isInOrNearImage(corner.pixel, view.size); });
    to.views.push_back(std::move(view));
  };
  for (int f = 0; f < num_frames; ++f) {
    const Eigen::Vector3d turn = upTo(rig.turns_rad);
    const SE3 rig_from_body = SE3(SO3::exp(turn), upTo(rig.steps_m)) * rig.rig_from_body;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      const TrueCamera& camera = rig.cameras[c];
      for (std::size_t b = 0; b < rig.body_from_board.size(); ++b) {
        if (b * rig.cameras.size() / (rig.body_from_board.size() * rig.num_together) != c / rig.num_together)
          continue;
        const SE3 camera_from_board = camera.camera_from_rig * rig_from_body * rig.body_from_board[b];
        addView(b, camera_from_board, "frame" + std::to_string(f), scene.views[c]);
      }
    }
  }
  for (std::size_t c = 0; c < rig.cameras.size() && rig.num_own > 0; ++c) {
    const TrueCamera& camera = rig.cameras[c];
    for (const SE3& pose : randomViews(camera.camera, camera.size, rig.boards.back(), rig.num_own, random))
      addView(rig.boards.size() - 1, pose,
              "own" + std::to_string(1000 * (c + 1) + scene.views[c].views.size()), scene.views[c]);
  }
  return scene;
}

}  // namespace alidade
