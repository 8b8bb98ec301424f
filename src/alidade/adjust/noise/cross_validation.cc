// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/cross_validation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "alidade/adjust/board/corner_noise.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/board/view_kernel.h"
#include "alidade/adjust/board/view_pose.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/parallel.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr std::size_t kMaxFolds = 5;
constexpr std::size_t kStretches = 4;  // per fold

std::vector<Observation> cornersOf(std::span<const Observation> view, const std::vector<std::size_t>& half) {
  return mapped(half, [&](std::size_t i) { return view[i]; });
}

// The fit without the views of one fold; nothing if the other views are not enough.
std::optional<Fit> withoutFold(int fold, const Fit& fit, const CancelFlag* cancel) {
  const FitCamera& camera = onlyCamera(fit);
  if (!isAnyUneven(fit) &&
      freeDirections(static_cast<int>(camera.params.size()), camera.constraint).cols() == 0)
    return fit;
  std::vector<bool> is_out(fit.views.size());
  for (std::size_t v = 0; v < is_out.size(); ++v) is_out[v] = foldOf(v, is_out.size()) == fold;
  Fit without = withoutViews(fit, is_out);
  fixShapes(without);
  // A loose tolerance: its effect on the errors is far below their scatter.
  without = solve(std::move(without), {.max_iterations = 100, .function_tolerance = 1e-8, .cancel = cancel});
  const Termination end = without.summary.termination;
  if (end == Termination::kFailed || end == Termination::kIterationLimit) return std::nullopt;
  return withOffsets(std::move(without), OffsetScatter::kKeep, cancel, kHeldOutAtRest);
}

// Errors of a view of `fit` with the camera and the board shape from the other views.
std::vector<Eigen::Vector2d> errorsOfView(const Fit& fit, const FitView& view, const Fit& without) {
  const FitCamera& camera = without.cameras[view.camera];
  const FitBoard& board = without.boards[view.board];
  const ViewKernel& kernel = viewKernel(camera.model, camera.params.size());
  const std::vector<Observation> all = onShape(board.target, shapeIn(board, view), view.corners);
  const SE3 pose = cameraFromBoard(fit, view);
  const CornerHalves halves = halvesOf(board.target, all);
  const std::array corners = {cornersOf(all, halves[0]), cornersOf(all, halves[1])};
  if (!givesPose(corners[0]) || !givesPose(corners[1])) return {};
  const std::array groups = {groupsOf(corners[0]), groupsOf(corners[1])};
  constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();
  std::vector<Eigen::Vector2d> errors(all.size(), Eigen::Vector2d::Constant(kUnseen));
  for (std::size_t half = 0; half < 2; ++half) {
    const std::size_t other = 1 - half;
    const auto refitted = refitPose(kernel, camera.params, groups[half], fit.loss, pose);
    if (!refitted) continue;
    std::vector<Eigen::Vector2d> of_other(corners[other].size());
    kernel.errors(camera.params.data(), *refitted, groups[other], of_other);
    for (std::size_t i = 0; i < of_other.size(); ++i) errors[halves[other][i]] = of_other[i];
  }
  return errors;
}

// The mean of one number per view, and its standard error from the scatter of the views.
struct ViewMean {
  double value = 0;
  double std = 0;
  double freedom = 0;

  [[nodiscard]] bool isPositive() const { return freedom > 0 && value > studentTOneSided95(freedom) * std; }
};

ViewMean meanOver(std::span<const double> of_view) {
  const auto n = static_cast<double>(of_view.size());
  double sum = 0;
  for (const double x : of_view) sum += x;
  double scatter = 0;
  for (const double x : of_view) scatter += (x - sum / n) * (x - sum / n);
  return {.value = sum / n, .std = std::sqrt(scatter / (n * (n - 1))), .freedom = n - 1};
}

}  // namespace

CornerHalves halvesOf(const Board& board, std::span<const Observation> view) {
  CornerHalves halves;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const int column = view[i].id % board.columns();
    const int row = view[i].id / board.columns();
    halves[static_cast<std::size_t>((column + row) & 1)].push_back(i);
  }
  return halves;
}

bool givesPose(std::span<const Observation> corners) {
  constexpr std::size_t kFewest = 4;
  constexpr double kLine = 0.02;  // ratio of the variances across and along
  if (corners.size() < kFewest) return false;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Observation& o : corners) mean += o.p_board.head<2>();
  mean /= static_cast<double>(corners.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Observation& o : corners) {
    const Eigen::Vector2d d = o.p_board.head<2>() - mean;
    scatter += d * d.transpose();
  }
  const SymmetricEigen solver(scatter);
  return solver.eigenvalues()(0) > kLine * solver.eigenvalues()(1);
}

int numFolds(std::size_t num_views) {
  return static_cast<int>(std::min(kMaxFolds, num_views));
}

int foldOf(std::size_t v, std::size_t num_views) {
  const auto num_folds = static_cast<std::size_t>(numFolds(num_views));
  const std::size_t num_stretches = std::min(num_views, num_folds * kStretches);
  const std::size_t stretch = v * num_stretches / num_views;
  // Each round starts one fold later; otherwise, if stretches differ in length, the same folds would always
  // get the longer ones.
  return static_cast<int>((stretch + stretch / num_folds) % num_folds);
}

std::optional<HeldOutErrors> heldOutErrors(const Fit& fit, int jobs, const CancelFlag* cancel,
                                           const FoldChange& change) {
  const std::size_t num_views = fit.views.size();
  HeldOutErrors held_out{.num_folds = numFolds(num_views), .px = {}};
  held_out.px.resize(num_views);
  const auto num_folds = static_cast<std::size_t>(held_out.num_folds);
  std::vector<char> is_determined(num_folds, 0);
  const auto leaveOut = [&](std::size_t i) {
    const int fold = static_cast<int>(i);
    std::optional<Fit> changed;
    if (change) {
      changed = fit;
      change(fold, *changed);
    }
    const Fit& own = changed ? *changed : fit;
    const auto without = withoutFold(fold, own, cancel);
    if (!without) return;
    is_determined[i] = 1;
    for (std::size_t v = 0; v < num_views; ++v) {
      if (foldOf(v, num_views) == fold) held_out.px[v] = errorsOfView(own, own.views[v], *without);
    }
  };
  parallelFor(num_folds, jobs, leaveOut, cancel);
  if (std::ranges::count(is_determined, 0) > 0) return std::nullopt;
  return held_out;
}

HoldoutReport holdoutReport(const std::optional<HeldOutErrors>& errors) {
  HoldoutReport report;
  if (!errors) return report;
  report.num_folds = errors->num_folds;
  double sum = 0;
  for (const auto& view : errors->px) {
    for (const Eigen::Vector2d& error : view) {
      const bool is_seen = error.allFinite();
      ++(is_seen ? report.num_corners : report.num_unseen);
      if (is_seen) sum += error.squaredNorm();
    }
  }
  if (report.num_corners > 0) report.rms_px = std::sqrt(sum / report.num_corners);
  return report;
}

double farOff(HuberLoss loss) {
  constexpr double kThresholds = 10;
  const double error_px = kThresholds * loss.threshold_px;
  return loss.rho(error_px * error_px);
}

double noiseFloor(std::size_t num_corners) {
  return 2 * kMinSigmaPx * kMinSigmaPx * static_cast<double>(num_corners);
}

HeldOutScore scoreOf(const HeldOutErrors& errors, const Fit& fit) {
  HeldOutScore score;
  for (std::size_t v = 0; v < errors.px.size(); ++v) {
    double sum = noiseFloor(errors.px[v].size());
    for (std::size_t i = 0; i < errors.px[v].size(); ++i) {
      const Eigen::Vector2d& error = errors.px[v][i];
      const double weight = fit.views[v].corners[i].weight;
      sum += error.allFinite() ? fit.loss.rho(weight * error.squaredNorm()) : farOff(fit.loss);
    }
    score.of_view.push_back(sum);
    score.sum += sum;
  }
  return score;
}

bool HeldOutExcess::isWorth(std::size_t num_further_params) const {
  return is_significant && proven_share > kShareOfParameter * static_cast<double>(num_further_params);
}

HeldOutExcess excessOf(const HeldOutScore& a, const HeldOutScore& b) {
  expect(a.of_view.size() == b.of_view.size(), "two models' errors on the same views");
  std::vector<double> differences;
  std::vector<double> log_ratios;
  for (std::size_t v = 0; v < a.of_view.size(); ++v) {
    if (!(a.of_view[v] > 0 && b.of_view[v] > 0)) continue;  // a view without held-out errors
    differences.push_back(a.of_view[v] - b.of_view[v]);
    log_ratios.push_back(std::log(a.of_view[v] / b.of_view[v]));
  }
  const ViewMean difference = meanOver(differences);
  const auto num_views = static_cast<double>(differences.size());
  const double ratio = std::sqrt(a.sum / b.sum);  // ratio of the RMS
  const ViewMean factor = meanOver(log_ratios);   // ratio of the squares
  const double share = ratio - 1;
  const double by_factor = factor.isPositive() ? std::min(share, std::expm1(0.5 * factor.value)) : 0.0;
  return {.share = share,
          .std = num_views * difference.std / (2 * b.sum * ratio),
          .is_significant = difference.isPositive() || factor.isPositive(),
          .proven_share = difference.isPositive() ? share : by_factor};
}

}  // namespace alidade
