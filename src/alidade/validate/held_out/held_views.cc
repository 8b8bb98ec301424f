// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "alidade/adjust/errors.h"
#include "alidade/adjust/view_pose.h"
#include "alidade/core/error.h"

namespace alidade {
std::optional<SE3> poseOf(const ComparedCamera& camera, const Checkerboard& board,
                          std::span<const Observation> corners, HuberLoss loss) {
  const std::string_view model = camera.camera->modelId();
  const auto params = camera.camera->parameters();
  const auto start = poseFromCorners(*camera.camera, corners);
  if (!start) return std::nullopt;
  const Eigen::Vector3d middle = board.middle();
  std::optional<SE3> best;
  double best_cost = std::numeric_limits<double>::infinity();
  // From afar two tilts look alike, and only the lesser cost tells them apart.
  for (const SE3& from : {*start, mirroredTilt(*start, middle)}) {
    const auto pose = refitPose(model, params, corners, loss, from);
    if (!pose) continue;
    const double cost = viewCost(model, params, *pose, corners, loss);
    if (!(cost < best_cost)) continue;
    best_cost = cost;
    best = pose;
  }
  return best;
}

double weightOf(const Fit& freed, std::size_t view) {
  constexpr double kSharedCorners = 10;
  const double mean_square = rms(freed) * rms(freed);
  const std::vector<Eigen::Vector2d>& errors = freed.views[view].errors;
  double sum = kSharedCorners * mean_square;
  for (const Eigen::Vector2d& error : errors) sum += error.squaredNorm();
  const double num_corners = static_cast<double>(errors.size()) + kSharedCorners;
  return sum > 0 ? mean_square * num_corners / sum : 1.0;
}

bool isTestable(const Checkerboard& board, const View& view) {
  constexpr std::size_t kFewestCorners = 4;
  for (const int colour : {0, 1}) {
    std::set<int> columns;
    std::set<int> rows;
    std::size_t count = 0;
    for (const Corner& corner : view.corners) {
      const int column = corner.id % board.columns;
      const int row = corner.id / board.columns;
      if ((column + row) % 2 != colour) continue;
      columns.insert(column);
      rows.insert(row);
      ++count;
    }
    if (count < kFewestCorners || columns.size() < 2 || rows.size() < 2) return false;
  }
  return true;
}

PosedViews posedByFreed(const PosedViews& held, const Fit& freed) {
  PosedViews posed = held;
  onlyCamera(posed.fit).params = onlyCamera(freed).params;
  for (const FitView& view : posed.fit.views)
    setCameraFromBoard(posed.fit, view, cameraFromBoard(freed, freed.views[view.source]));
  return posed;
}

std::optional<PosedViews> reposed(const AnyCamera& camera, const PosedViews& near, const PosedViews* freed) {
  const auto params = camera.parameters();
  const std::string_view model = camera.modelId();
  PosedViews posed = near;
  onlyCamera(posed.fit).params.assign(params.begin(), params.end());
  for (std::size_t v = 0; v < near.fit.views.size(); ++v) {
    const std::vector<Observation> corners = cornersOnShape(near.fit, near.fit.views[v]);
    std::optional<SE3> best;
    double best_cost = std::numeric_limits<double>::infinity();
    const auto tryFrom = [&](const SE3& start) {
      const auto pose = refitPose(model, params, corners, kNoLoss, start);
      if (!pose) return;
      const double cost = viewCost(model, params, *pose, corners, kNoLoss);
      if (!(cost < best_cost)) return;
      best_cost = cost;
      best = pose;
    };
    tryFrom(cameraFromBoard(near.fit, near.fit.views[v]));
    if (freed != nullptr) tryFrom(cameraFromBoard(freed->fit, freed->fit.views[v]));
    if (!best) return std::nullopt;
    setCameraFromBoard(posed.fit, posed.fit.views[v], *best);
  }
  return posed;
}

}  // namespace alidade
