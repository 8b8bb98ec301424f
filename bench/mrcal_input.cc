// SPDX-License-Identifier: MIT
#include "mrcal_input.h"

#include <cstdio>
#include <optional>
#include <vector>

namespace alidade {
namespace {

void printPose(FILE* to, const SE3& pose) {
  const Eigen::Vector3d r = pose.rotation.log();
  const Eigen::Vector3d& t = pose.translation;
  std::fprintf(to, "%.17g %.17g %.17g %.17g %.17g %.17g\n", r.x(), r.y(), r.z(), t.x(), t.y(), t.z());
}

}  // namespace

bool solveByMrcal(const Fit& fit, int num_repetitions) {
  FILE* script = popen("/usr/bin/python3 " ALIDADE_MRCAL_SCRIPT, "w");
  if (script == nullptr) return false;
  const Board& board = onlyBoard(fit).target;
  const double spacing = board.corner(1).x() - board.corner(0).x();
  const ImageSize size = fit.cameras.front().size;
  std::fprintf(script, "%d %d %.17g %d %d %zu %zu %zu %d\n", board.columns(), board.rows(), spacing,
               size.width, size.height, fit.cameras.size(), fit.placements.size(), fit.views.size(),
               num_repetitions);
  for (const FitCamera& camera : fit.cameras) {
    for (const double p : camera.params) std::fprintf(script, "%.17g ", p);
    printPose(script, camera.camera_from_rig);
  }
  for (const FitPlacement& placement : fit.placements) printPose(script, placement.rig_from_body);
  for (const FitView& view : fit.views) {
    std::fprintf(script, "%zu %zu", view.placement, view.camera);
    std::vector<const Observation*> of_id(static_cast<std::size_t>(board.numCorners()));
    for (const Observation& corner : view.corners) of_id[static_cast<std::size_t>(corner.id)] = &corner;
    for (const Observation* corner : of_id) {
      if (corner == nullptr) {
        std::fprintf(script, " 0 0 -1");
      } else {
        std::fprintf(script, " %.17g %.17g 1", corner->pixel.x(), corner->pixel.y());
      }
    }
    std::fprintf(script, "\n");
  }
  return pclose(script) == 0;
}

}  // namespace alidade
