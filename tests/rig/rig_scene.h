// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/rig/rig_calibrator.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"

namespace alidade {

struct TrueCamera {
  AnyCamera camera;
  ImageSize size;
  SE3 camera_from_rig;
};

inline SE3 poseAt(double x, double y, double z, double turn_y) {
  return {SO3::exp(Eigen::Vector3d(0.01, turn_y, -0.02)), Eigen::Vector3d(x, y, z)};
}

// Three different cameras side by side.
inline std::vector<TrueCamera> threeCameras() {
  const std::vector<double> radtan = {900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0};
  const std::vector<double> fisheye = {420, 421, 512, 383, 0.01, -0.003, 0.001, 0};
  const std::vector<double> pinhole = {700, 700, 400, 300};
  return {{AnyCamera::make("radtan", radtan), {1280, 960}, {}},
          {AnyCamera::make("kannala_brandt", fisheye), {1024, 768}, poseAt(-0.2, 0.01, 0.02, 0.15)},
          {AnyCamera::make("pinhole", pinhole), {800, 600}, poseAt(0.18, -0.02, 0.01, -0.1)}};
}

inline const Board kCharuco =
    CharucoBoard{.columns = 11, .rows = 8, .square_m = 0.03, .marker_m = 0.022, .dictionary = "DICT_4X4_250"};
inline const Board kAmbiguous = Checkerboard{.columns = 8, .rows = 6, .square_m = 0.03};
inline const Board kSquare = Checkerboard{.columns = 6, .rows = 6, .square_m = 0.04};

struct RigScene {
  std::vector<TrueCamera> cameras;
  std::vector<RigViews> views;
};

// Boards that the first camera sees as a whole, seen by the others as far as they see them.
inline RigScene sceneOf(std::vector<TrueCamera> cameras, const Board& board, int num_frames, double noise_px,
                        std::uint64_t seed, const BoardShape& shape = {}) {
  Random random(seed);
  RigScene scene{.cameras = std::move(cameras), .views = {}};
  const TrueCamera& first = scene.cameras.front();
  const std::vector<SE3> poses = randomViews(first.camera, first.size, board, num_frames, random);
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    const TrueCamera& camera = scene.cameras[c];
    RigViews& of_camera =
        scene.views.emplace_back(RigViews{.name = "camera" + std::to_string(c), .views = {}});
    for (int i = 0; i < num_frames; ++i) {
      const SE3 rig_from_board = first.camera_from_rig.inverse() * poses[static_cast<std::size_t>(i)];
      const SE3 camera_from_board = camera.camera_from_rig * rig_from_board;
      View view = exactView(camera.camera, camera.size, board, camera_from_board,
                            "frame" + std::to_string(i) + ".png");
      if (view.corners.size() < 12) continue;
      for (Corner& corner : view.corners)
        corner.pixel = camera.camera.projectPoint(camera_from_board * pointOn(board, shape, corner.id)).pixel;
      if (noise_px > 0) addCornerNoise(view, noise_px, random);
      for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
      std::erase_if(view.corners,
                    [&](const Corner& corner) { return !isInOrNearImage(corner.pixel, view.size); });
      of_camera.views.push_back(std::move(view));
    }
  }
  return scene;
}

inline RigOptions optionsFor(const RigScene& scene) {
  RigOptions options;
  options.camera.board_shape = BoardShapeMode::kFlat;
  options.camera.jobs = 2;
  for (const TrueCamera& camera : scene.cameras) options.models.emplace_back(camera.camera.modelId());
  return options;
}

// The error of a camera's pose relative to the first one, as a tangent.
inline Eigen::Matrix<double, 6, 1> poseError(const RigScene& scene, const RigCalibration& rig,
                                             std::size_t camera) {
  const SE3 truth = scene.cameras[camera].camera_from_rig * scene.cameras.front().camera_from_rig.inverse();
  return (truth.inverse() * rig.fit.cameras[camera].camera_from_rig).log();
}

inline auto hasDiagnosis(const char* id) {
  return testing::Field(&RigCalibration::diagnoses,
                        testing::Contains(testing::Field(&Diagnosis::id, testing::Eq(std::string_view(id)))));
}

}  // namespace alidade
