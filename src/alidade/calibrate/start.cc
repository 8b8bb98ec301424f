// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start.h"

#include <algorithm>
#include <cmath>

#include "alidade/init/closed_form_intrinsics.h"
#include "alidade/init/homography.h"
#include "alidade/init/pose_from_homography.h"

namespace alidade {
namespace {

constexpr std::size_t kMaxViews = 20;  // enough to choose a start; the rest joins in the full solve
constexpr std::size_t kNumSolved = 3;
constexpr std::size_t kMinPosed = 3;  // views with a pose, or the start says nothing
constexpr int kMaxIterations = 100;
constexpr double kFunctionTolerance = 1e-6;  // tells candidates apart; the full solve goes on to the optimum

struct Candidate {
  BundleState state;
  std::vector<std::vector<Observation>> observations;  // of the views with a pose
  double missing_cost = 0;                             // charged for the views without one
  double cost = 0;
};

std::vector<View> spreadOf(std::span<const View> views) {
  std::vector<View> some;
  const std::size_t count = std::min(kMaxViews, views.size());
  for (std::size_t i = 0; i < count; ++i) some.push_back(views[i * views.size() / count]);
  return some;
}

// Half the sum of rho, as the solver counts it; NaN if a corner does not project.
double robustCost(std::string_view model_id, const BundleState& state,
                  std::span<const std::vector<Observation>> observations, HuberLoss loss) {
  double cost = 0;
  for (std::size_t v = 0; v < observations.size(); ++v) {
    for (const auto& error :
         reprojectionErrors(model_id, state.params, state.camera_from_board[v], observations[v])) {
      cost += 0.5 * loss.rho(error.squaredNorm());
    }
  }
  return cost;
}

// A start at which a view has no pose pays for it as if all its corners were far off: a bad start must not
// win by losing views, and one bad view must not rule out every start.
double missingViewCost(std::size_t num_corners, HuberLoss loss) {
  constexpr double kFarOff = 10;  // thresholds of the loss
  const double error = kFarOff * loss.threshold_px;
  return 0.5 * static_cast<double>(num_corners) * loss.rho(error * error);
}

std::vector<Eigen::Matrix3d> homographiesOf(const Checkerboard& board, std::span<const View> views) {
  std::vector<Eigen::Matrix3d> homographies;
  for (const View& view : views) {
    std::vector<Eigen::Vector2d> on_board;
    std::vector<Eigen::Vector2d> pixels;
    for (const Corner& corner : view.corners) {
      on_board.emplace_back(board.corner(corner.id).head<2>());
      pixels.push_back(corner.pixel);
    }
    if (const auto H = fitHomography(on_board, pixels)) homographies.push_back(*H);
  }
  return homographies;
}

}  // namespace

std::vector<std::vector<Observation>> observationsOf(const Checkerboard& board, std::span<const View> views) {
  std::vector<std::vector<Observation>> all(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const Corner& corner : views[v].corners) {
      all[v].push_back({board.corner(corner.id), corner.pixel, corner.sigma_px});
    }
  }
  return all;
}

std::optional<std::vector<double>> findStart(std::string_view model_id, const Checkerboard& board,
                                             std::span<const View> all_views, const CancelFlag* cancel) {
  const std::vector<View> views = spreadOf(all_views);
  const auto observations = observationsOf(board, views);
  const ImageSize size = views.front().size;
  const HuberLoss loss{.threshold_px = 0.005 * std::hypot(size.width, size.height)};

  std::vector<Candidate> candidates;
  for (const AffineStart& start : affineStarts(homographiesOf(board, views), size)) {
    Candidate candidate;
    candidate.state.params = startParameters(model_id, start.fx, size);
    candidate.state.params[1] *= start.fy / start.fx;
    candidate.state.params[2] = start.cx;
    candidate.state.params[3] = start.cy;
    const AnyCamera camera = AnyCamera::make(model_id, candidate.state.params);
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (const auto pose = poseFromView(camera, board, views[v].corners)) {
        candidate.state.camera_from_board.push_back(*pose);
        candidate.observations.push_back(observations[v]);
      } else {
        candidate.missing_cost += missingViewCost(observations[v].size(), loss);
      }
    }
    if (candidate.observations.size() < kMinPosed) continue;
    candidate.cost =
        candidate.missing_cost + robustCost(model_id, candidate.state, candidate.observations, loss);
    if (std::isfinite(candidate.cost)) candidates.push_back(std::move(candidate));
  }
  const auto cheaper = [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; };
  std::stable_sort(candidates.begin(), candidates.end(), cheaper);
  if (candidates.size() > kNumSolved) candidates.resize(kNumSolved);

  const Candidate* best = nullptr;
  for (Candidate& candidate : candidates) {
    const BundleSummary summary = solveBundle(model_id, candidate.observations, candidate.state,
                                              {.loss = loss,
                                               .max_iterations = kMaxIterations,
                                               .function_tolerance = kFunctionTolerance,
                                               .cancel = cancel});
    candidate.cost = candidate.missing_cost + summary.cost;
    // An iteration limit is no failure here: the full solve goes on from where this one stopped.
    if (summary.termination == Termination::kFailed) continue;
    if (best == nullptr || candidate.cost < best->cost) best = &candidate;
  }
  if (best == nullptr) return std::nullopt;
  return best->state.params;
}

}  // namespace alidade
