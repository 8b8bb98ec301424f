// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string>
#include <vector>

#include "alidade/files/corners_file.h"
#include "alidade/files/rig_file.h"
#include "alidade/record/rig_record.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "support/scratch_folder.h"

namespace alidade {

/// A rig of an ordinary lens and a fisheye, 0.12 m apart and turned against each other, with a covariance of
/// half a pixel for focal lengths and principal points, and 1 mm and 1 mrad for the pose.
inline RigRecord pairOfCameras() {
  const auto entry = [](const std::string& name, std::string_view model, const std::vector<double>& params,
                        const SE3& camera_from_rig) {
    CameraRecord record = bareRecord(AnyCamera::make(model, params), {640, 480}, "a test");
    record.name.name = name;
    return RigCameraRecord{.camera = record, .camera_from_rig = camera_from_rig};
  };
  const SE3 turned{SO3::exp(Eigen::Vector3d(0.02, -0.05, 0.03)), Eigen::Vector3d(-0.12, 0.004, 0.002)};
  RigRecord rig;
  rig.cameras = {entry("left", "radtan", {520, 522, 318, 241, -0.2, 0.05, 1e-3, -5e-4, 0}, {}),
                 entry("right", "kannala_brandt", {300, 301, 322, 239, 0.01, -0.002, 0, 0}, turned)};
  Eigen::VectorXd variances = Eigen::VectorXd::Constant(9 + 8 + 6, 1e-6);
  for (const Eigen::Index start : {0, 9}) {
    variances.segment(start, 4).setConstant(0.25);
    variances.segment(start + 4, start == 0 ? 5 : 4).setConstant(1e-8);
  }
  rig.covariance = lowerTriangle(variances.asDiagonal().toDenseMatrix());
  rig.created_by = "a test";
  return rig;
}

/// The corners of a board of 9x6 corners as each camera of pairOfCameras() sees it, with normal noise, in the
/// images view_001.png to view_012.png.
inline std::array<CornersFile, 2> cornersOfPair(double noise_px = 0.05, unsigned seed = 7) {
  constexpr std::size_t kCount = 12;
  const Board board = Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025};
  const AnyRig rig = rigOf(pairOfCameras());
  Random random(seed);
  std::array<CornersFile, 2> files;
  for (std::size_t i = 0; i < 2; ++i) {
    files[i].camera = rig.camera(i).name;
    files[i].boards = {board};
  }
  const std::vector<SE3> poses =
      randomViews(rig.camera(0).camera, rig.camera(0).image_size, board, 4 * kCount, random);
  for (const SE3& camera_from_board : poses) {
    const std::size_t number = files[0].views.size() + 1;
    if (number > kCount) break;
    const std::string image =
        std::string(number < 10 ? "view_00" : "view_0") + std::to_string(number) + ".png";
    const SE3 rig_from_board = rig.camera(0).camera_from_rig.inverse() * camera_from_board;
    std::array<View, 2> views;
    for (std::size_t i = 0; i < 2; ++i) {
      const MountedCamera& camera = rig.camera(i);
      views[i] =
          exactView(camera.camera, camera.image_size, board, camera.camera_from_rig * rig_from_board, image);
    }
    if (views[1].corners.size() < views[0].corners.size()) continue;  // both see the whole board
    for (std::size_t i = 0; i < 2; ++i) {
      addCornerNoise(views[i], noise_px, random);
      files[i].views.push_back(std::move(views[i]));
    }
  }
  return files;
}

/// Writes them to left.csv and right.csv.
inline void writeCornersOfPair(const ScratchFolder& scratch, double noise_px = 0.05, unsigned seed = 7) {
  const std::array<CornersFile, 2> files = cornersOfPair(noise_px, seed);
  for (const CornersFile& file : files) writeCornersFile(scratch.path(file.camera + ".csv"), file);
}

}  // namespace alidade
