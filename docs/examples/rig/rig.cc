// SPDX-License-Identifier: MIT
// Calibrates two cameras together from corners of a board, writes the rig file, reads it back, and projects a
// point into both cameras. The corners are computed here; a program of yours reads them with
// readCornersFile() or finds them with surveyImages().
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "alidade/camera.h"
#include "alidade/files.h"
#include "alidade/rig.h"

namespace {

constexpr alidade::ImageSize kSize{640, 480};

// A board in front of both cameras, tilted differently in each frame.
std::vector<alidade::View> viewsOf(const alidade::MountedCamera& camera, const alidade::Board& board) {
  std::vector<alidade::View> views;
  for (int i = 0; i < 16; ++i) {
    alidade::SE3 rig_from_board;
    rig_from_board.rotation = alidade::SO3::exp({0.5 * std::cos(i), 0.5 * std::sin(i), 0.1 * i});
    const Eigen::Vector3d centre(0.05 + 0.06 * std::cos(2 * i), 0.04 * std::sin(2 * i), 0.4);
    rig_from_board.translation = centre - rig_from_board.rotation * board.middle();
    alidade::View view{.image = "frame_" + std::to_string(i), .size = kSize};
    for (int id = 0; id < board.numCorners(); ++id) {
      const auto projection =
          camera.camera.project(camera.camera_from_rig * (rig_from_board * board.corner(id)));
      if (projection.ok()) view.corners.push_back({.id = id, .pixel = projection.pixel});
    }
    views.push_back(std::move(view));
  }
  return views;
}

alidade::AnyRig trueRig() {
  const std::vector<double> params = {532, 533, 321, 237, -0.28, 0.06, 1e-3, -5e-4, 0.0};
  alidade::MountedCamera left{
      .name = "left", .camera = alidade::AnyCamera::make("radtan", params), .image_size = kSize};
  alidade::MountedCamera right = left;
  right.name = "right";
  right.camera_from_rig.translation = {-0.1, 0, 0};
  right.camera_from_rig.rotation = alidade::SO3::exp({0, 0.05, 0});
  return alidade::AnyRig({left, right});
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : ".";
  const alidade::Board board = alidade::Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025};
  const alidade::AnyRig truth = trueRig();
  std::vector<alidade::RigViews> cameras;
  for (const alidade::MountedCamera& camera : truth.cameras())
    cameras.push_back({.name = camera.name, .views = viewsOf(camera, board)});

  const alidade::RigCalibration rig =
      alidade::calibrate(board, std::move(cameras), {.camera = {.model = "radtan"}});
  for (const alidade::Diagnosis& diagnosis : rig.diagnoses) std::puts(diagnosis.message().c_str());
  alidade::saveRig(folder + "/rig.yaml", alidade::recordOf(rig, "my program"));

  const alidade::AnyRig read = alidade::rigOf(alidade::loadRig(folder + "/rig.yaml"));
  const Eigen::Vector3d point(0.05, 0.02, 0.8);
  double worst_px = 0;
  for (std::size_t i = 0; i < read.size(); ++i) {
    const alidade::Projection pixel = read.project(i, point);
    std::printf("%s sees the point at (%.2f, %.2f)\n", read.camera(i).name.c_str(), pixel.pixel.x(),
                pixel.pixel.y());
    worst_px = std::max(worst_px, (pixel.pixel - truth.project(i, point).pixel).norm());
  }
  return worst_px < 0.01 ? 0 : 1;
}
