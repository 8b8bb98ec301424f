// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_stages.h"

#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

// The fold of each frame.
std::vector<int> foldsOf(const std::set<std::size_t>& frames) {
  std::vector<int> fold(frames.empty() ? 0 : *frames.rbegin() + 1);
  std::size_t rank = 0;
  for (const std::size_t frame : frames) fold[frame] = foldOf(rank++, frames.size());
  return fold;
}

bool isSolved(const Fit& fit) {
  return fit.summary.termination != Termination::kFailed &&
         fit.summary.termination != Termination::kIterationLimit;
}

std::vector<Observation> halfOf(const Board& board, const std::vector<Observation>& corners,
                                std::size_t half) {
  return mapped(halvesOf(board, corners)[half], [&](std::size_t i) { return corners[i]; });
}

// Holds all cameras and boards, so that only placements are estimated.
void holdRest(Fit& fit, const Fit& from) {
  fit.boards = from.boards;
  for (FitBoard& board : fit.boards) board.is_body_pose_fixed = true;
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    FitCamera& camera = fit.cameras[c];
    camera.params = from.cameras[c].params;
    camera.camera_from_rig = from.cameras[c].camera_from_rig;
    camera.constraint = {.held = std::vector<int>(camera.params.size())};
    std::iota(camera.constraint.held.begin(), camera.constraint.held.end(), 0);
    camera.weak_prior = {};
    camera.is_rig_pose_fixed = true;
    camera.delay = from.cameras[c].delay;
    camera.is_delay_fixed = true;
  }
}

void addErrors(const Fit& held_out, const CancelFlag* cancel, HoldoutReport& report, double& sum) {
  for (const std::size_t half : {0U, 1U}) {
    Fit fit = held_out;
    std::vector<bool> is_out;
    for (FitView& view : fit.views) {
      view.corners = halfOf(boardOf(fit, view).target, view.corners, half);
      if (view.deviation) view.deviation->normal.setZero();  // the other half took part in its estimate
      is_out.push_back(!givesPose(view.corners));
    }
    Fit solved = solve(withoutViews(fit, is_out), {.cancel = cancel});
    if (!isSolved(solved)) {
      report.num_unseen += static_cast<int>(numCorners(fit));
      continue;
    }
    std::size_t v = 0;  // in the solved fit
    for (std::size_t i = 0; i < held_out.views.size(); ++i) {
      if (is_out[i]) continue;
      FitView other = solved.views[v++];
      other.corners = halfOf(boardOf(solved, other).target, held_out.views[i].corners, 1 - half);
      for (const Eigen::Vector2d& error : viewErrors(solved, other)) {
        ++(error.allFinite() ? report.num_corners : report.num_unseen);
        if (error.allFinite()) sum += error.squaredNorm();
      }
    }
  }
}

}  // namespace

HoldoutReport rigHoldout(const Fit& fit, const CancelFlag* cancel) {
  Fit whole = fit;
  fixShapes(whole);
  std::set<std::size_t> frames;
  for (const FitPlacement& placement : fit.placements) frames.insert(placement.frame);
  const std::vector<int> folds = foldsOf(frames);
  HoldoutReport report{.num_folds = numFolds(frames.size())};
  double sum = 0;
  for (int fold = 0; fold < report.num_folds; ++fold) {
    std::vector<bool> is_out = mapped(whole.views, [&](const FitView& view) {
      return folds[whole.placements[view.placement].frame] == fold;
    });
    Fit others = solve(withoutViews(whole, is_out),
                       {.max_iterations = 100, .function_tolerance = 1e-8, .cancel = cancel});
    if (!isSolved(others)) return {};
    auto uneven = withOffsets(std::move(others), OffsetScatter::kKeep, cancel, kHeldOutAtRest);
    if (!uneven) return {};
    others = *std::move(uneven);
    is_out.flip();
    Fit held_out = withoutViews(whole, is_out);
    holdRest(held_out, others);
    addErrors(held_out, cancel, report, sum);
  }
  if (report.num_corners > 0) report.rms_px = std::sqrt(sum / report.num_corners);
  return report;
}

}  // namespace alidade
