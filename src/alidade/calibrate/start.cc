// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "alidade/camera/model_list.h"
#include "alidade/init/lens_shapes.h"
#include "alidade/init/pose_from_rays.h"

namespace alidade {
namespace {

using Observations = std::vector<std::vector<Observation>>;

constexpr std::size_t kMaxViews = 20;  // enough to choose a start; the rest joins in the full solve
constexpr std::size_t kMinPosed = 3;   // views with a pose, or the start says nothing
constexpr std::size_t kMaxOptima = 3;  // compared on all views
constexpr int kMaxIterations = 100;
// Relative change of the cost at which to stop.
constexpr double kFine = 1e-6;    // tells optima apart; the full solve goes on to the optimum
constexpr double kCoarse = 1e-3;  // on the way to another solve

struct Candidate : PosedCamera {
  double cost = 0;  // with what is charged for views without a pose
};

// Half the sum of rho, as the solver counts it; NaN if a corner does not project.
double viewCost(std::string_view model_id, std::span<const double> params, const SE3& pose,
                std::span<const Observation> view, HuberLoss loss) {
  double cost = 0;
  for (const Eigen::Vector2d& error : reprojectionErrors(model_id, params, pose, view))
    cost += 0.5 * loss.rho(error.squaredNorm());
  return cost;
}

Eigen::Vector3d meanPoint(std::span<const Observation> view) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Observation& observation : view) sum += observation.p_board;
  return sum / static_cast<double>(view.size());
}

// To what solves of this tolerance reach. Optima of two shapes may have all but the same projections.
bool isSameLens(std::span<const double> a, std::span<const double> b) {
  constexpr double kRelative = 1e-2;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i] - b[i]) > kRelative * std::max({std::abs(a[i]), std::abs(b[i]), 1.0})) return false;
  }
  return true;
}

bool isCheaper(const Candidate& a, const Candidate& b) {
  return a.cost < b.cost;
}

std::vector<std::size_t> spreadOf(std::size_t num_views) {
  std::vector<std::size_t> some;
  const std::size_t count = std::min(kMaxViews, num_views);
  for (std::size_t i = 0; i < count; ++i) some.push_back(i * num_views / count);
  return some;
}

// The model whose solution the search begins with.
std::string leadingModel(std::string_view model_id) {
  if (model_id == Pinhole::kId) return std::string(model_id);
  bool contains_radtan = false;
  bool is_nested = false;
  forEachModel(NestedModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    contains_radtan = contains_radtan || M::kId == Radtan::kId;
    is_nested = is_nested || (contains_radtan && M::kId == model_id);
  });
  return std::string(is_nested ? Radtan::kId : KannalaBrandt::kId);
}

// Pixels a radian on the axis for fields of view across the longer side.
std::vector<double> focalLengths(std::string_view leading_id, ImageSize size) {
  const double half_side = 0.5 * std::max(size.width, size.height);
  const auto half = [](double fov_deg) { return 0.5 * fov_deg * std::numbers::pi / 180; };
  std::vector<double> focals;
  if (leading_id == KannalaBrandt::kId) {
    for (const double fov : {15.0, 25.0, 40.0, 60.0, 90.0, 120.0, 150.0, 180.0, 210.0})
      focals.push_back(half_side / half(fov));
  } else {
    for (const double fov : {15.0, 25.0, 40.0, 60.0, 80.0, 100.0, 120.0})
      focals.push_back(half_side / std::tan(half(fov)));
  }
  return focals;
}

// From the poses of the chosen views, as solved, to those of all views.
void poseAll(std::string_view model_id, const Checkerboard& board, std::span<const View> views,
             std::span<const std::size_t> chosen, HuberLoss loss, PosedCamera& posed) {
  std::vector<std::optional<SE3>> poses(views.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) poses[chosen[i]] = posed.poses[i];
  posed.poses = std::move(poses);
  improvePoses(model_id, board, views, loss, posed);
}

// The search on some of the views.
class Search {
 public:
  Search(const Checkerboard& board, std::vector<View> views, const CancelFlag* cancel)
      : board_(board),
        views_(std::move(views)),
        observations_(observationsOf(board, views_)),
        size_(views_.front().size),
        loss_(startLoss(size_)),
        cancel_(cancel) {}

  std::optional<Start> run(std::string_view model_id) const {
    const std::string leading_id = leadingModel(model_id);
    std::vector<Candidate> candidates;
    for (const double focal : focalLengths(leading_id, size_)) {
      Candidate candidate{{.params = startParameters(leading_id, focal, size_), .poses = {}}};
      findPoses(leading_id, candidate);
      if (std::isfinite(candidate.cost)) candidates.push_back(std::move(candidate));
    }
    Start start;
    const std::optional<Candidate> leading = solveBest(leading_id, candidates, start.report);
    if (!leading) return std::nullopt;
    if (leading_id == model_id) {
      start.camera = *leading;
      return start;
    }
    std::vector<Candidate> optima = reshape(leading_id, *leading, model_id);
    if (optima.empty()) return std::nullopt;
    start.report.num_optima = static_cast<int>(optima.size());
    start.camera = std::move(optima.front());
    for (std::size_t i = 1; i < optima.size(); ++i) start.rivals.push_back(std::move(optima[i]));
    return start;
  }

 private:
  // Solves candidates in order of their cost until two agree; the best one.
  std::optional<Candidate> solveBest(std::string_view model_id, std::vector<Candidate>& candidates,
                                     StartReport& report) const {
    std::stable_sort(candidates.begin(), candidates.end(), isCheaper);
    std::vector<Candidate> solved;
    std::size_t best = 0;
    report = {.num_tried = static_cast<int>(candidates.size())};
    for (Candidate& candidate : candidates) {
      if (!solveLeanly(model_id, candidate) || !solve(model_id, candidate)) continue;
      solved.push_back(std::move(candidate));
      if (solved.back().cost < solved[best].cost) best = solved.size() - 1;
      report.num_solved = static_cast<int>(solved.size());
      report.num_agreed = static_cast<int>(std::count_if(solved.begin(), solved.end(), [&](const auto& c) {
        return isSameOptimum(model_id, c, solved[best]);
      }));
      if (report.num_agreed >= 2) break;
    }
    if (solved.empty()) return std::nullopt;
    return std::move(solved[best]);
  }

  // From the solution of the leading model to those of the model that was asked for: the best one, and all
  // distinct ones that are about as good.
  std::vector<Candidate> reshape(std::string_view leading_id, const Candidate& leading,
                                 std::string_view model_id) const {
    std::vector<Eigen::Vector2d> pixels;
    for (const View& view : views_) {
      constexpr std::size_t kEvery = 7;  // no divisor of usual boards' columns
      for (std::size_t i = 0; i < view.corners.size(); i += kEvery) pixels.push_back(view.corners[i].pixel);
    }
    std::vector<Candidate> solved;
    double best_cost = std::numeric_limits<double>::infinity();
    for (const LensShape& shape : lensShapes(model_id, AnyCamera::make(leading_id, leading.params), pixels)) {
      Candidate candidate{{.params = shape.params, .poses = leading.poses}};
      if (shape.character) {
        constexpr double kHopeless = 100;  // times the best cost: no shape comes down from there
        if (!solve(model_id, candidate, kCoarse, {*shape.character})) continue;
        if (candidate.cost > kHopeless * best_cost) continue;
      }
      if (!solve(model_id, candidate)) continue;
      best_cost = std::min(best_cost, candidate.cost);
      solved.push_back(std::move(candidate));
    }
    std::stable_sort(solved.begin(), solved.end(), isCheaper);
    std::vector<Candidate> optima;
    for (Candidate& candidate : solved) {
      constexpr double kRival = 1.2;  // times the best cost: the views left out may reverse that
      if (candidate.cost > kRival * best_cost) break;
      const bool is_known = std::any_of(optima.begin(), optima.end(), [&](const Candidate& other) {
        return isSameLens(candidate.params, other.params);
      });
      if (!is_known) optima.push_back(std::move(candidate));
      if (optima.size() == kMaxOptima) break;
    }
    return optima;
  }

  void findPoses(std::string_view model_id, Candidate& candidate) const {
    const AnyCamera camera = AnyCamera::make(model_id, candidate.params);
    candidate.poses.assign(views_.size(), std::nullopt);
    candidate.cost = 0;
    std::size_t num_posed = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const auto pose = poseFromView(camera, board_, views_[v].corners);
      const double cost = pose ? viewCost(model_id, candidate.params, *pose, observations_[v], loss_)
                               : std::numeric_limits<double>::quiet_NaN();
      if (std::isfinite(cost)) {
        candidate.poses[v] = pose;
        candidate.cost += cost;
        ++num_posed;
      } else {
        candidate.cost += missingViewCost(observations_[v].size());
      }
    }
    if (num_posed < std::min(kMinPosed, views_.size()))
      candidate.cost = std::numeric_limits<double>::infinity();
  }

  // A start at which a view has no pose pays for it as if all its corners were far off: a bad start must not
  // win by losing views, and one bad view must not rule out every start.
  double missingViewCost(std::size_t num_corners) const {
    constexpr double kFarOff = 10;  // thresholds of the loss
    const double error = kFarOff * loss_.threshold_px;
    return 0.5 * static_cast<double>(num_corners) * loss_.rho(error * error);
  }

  // Focal lengths, the first coefficient of the distortion and poses alone. With more, views with a wrong
  // tilt would bend the principal point and the higher coefficients to themselves, and stay.
  bool solveLeanly(std::string_view model_id, Candidate& candidate) const {
    std::vector<int> held = {2, 3};
    for (int i = 5; i < static_cast<int>(candidate.params.size()); ++i) held.push_back(i);
    if (!solve(model_id, candidate, kCoarse, std::move(held))) return false;
    improvePoses(model_id, board_, views_, loss_, candidate);
    return true;
  }

  // Solves a candidate until no pose by rays is better than the one that a view came to.
  bool solve(std::string_view model_id, Candidate& candidate) const {
    constexpr int kMaxRounds = 3;
    for (int round = 0; round < kMaxRounds; ++round) {
      if (!solve(model_id, candidate, kFine, {})) return false;
      if (!improvePoses(model_id, board_, views_, loss_, candidate)) break;
    }
    return true;
  }

  bool solve(std::string_view model_id, Candidate& candidate, double tolerance, std::vector<int> held) const {
    BundleState state{.params = candidate.params, .camera_from_board = {}};
    Observations posed;
    double missing_cost = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (candidate.poses[v] &&
          std::isfinite(viewCost(model_id, candidate.params, *candidate.poses[v], observations_[v], loss_))) {
        state.camera_from_board.push_back(*candidate.poses[v]);
        posed.push_back(observations_[v]);
      } else {
        candidate.poses[v].reset();
        missing_cost += missingViewCost(observations_[v].size());
      }
    }
    if (posed.size() < kMinPosed) return false;
    const BundleSummary summary = solveBundle(model_id, posed, state,
                                              {.loss = loss_,
                                               .max_iterations = kMaxIterations,
                                               .function_tolerance = tolerance,
                                               .constraint = {.held = std::move(held)},
                                               .cancel = cancel_});
    // An iteration limit is no failure here: the full solve goes on from where this one stopped.
    if (summary.termination == Termination::kFailed) return false;
    candidate.params = state.params;
    candidate.cost = missing_cost + summary.cost;
    std::size_t i = 0;
    for (auto& pose : candidate.poses) {
      if (pose) pose = state.camera_from_board[i++];
    }
    return true;
  }

  // Same cost and same projections of all corners.
  bool isSameOptimum(std::string_view model_id, const Candidate& a, const Candidate& b) const {
    constexpr double kSameCost = 1e-4;
    constexpr double kSameErrors = 0.05;  // root mean square of the difference as a share of the errors
    if (std::abs(a.cost - b.cost) > kSameCost * std::min(a.cost, b.cost)) return false;
    double sum = 0;
    double sum_difference = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (a.poses[v].has_value() != b.poses[v].has_value()) return false;
      if (!a.poses[v]) continue;
      const auto errors_a = reprojectionErrors(model_id, a.params, *a.poses[v], observations_[v]);
      const auto errors_b = reprojectionErrors(model_id, b.params, *b.poses[v], observations_[v]);
      for (std::size_t i = 0; i < errors_a.size(); ++i) {
        sum += errors_a[i].squaredNorm();
        sum_difference += (errors_a[i] - errors_b[i]).squaredNorm();
      }
    }
    return sum_difference <= kSameErrors * kSameErrors * sum;
  }

  const Checkerboard& board_;
  std::vector<View> views_;
  Observations observations_;
  ImageSize size_;
  HuberLoss loss_;
  const CancelFlag* cancel_;
};

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

HuberLoss startLoss(ImageSize size) {
  return {.threshold_px = 0.005 * std::hypot(size.width, size.height)};
}

std::optional<SE3> refinedPose(std::string_view model_id, const std::vector<double>& params, const SE3& pose,
                               const std::vector<Observation>& view, HuberLoss loss) {
  // A start that does not project is a view that cannot be posed, and not the solver's business.
  if (!std::isfinite(viewCost(model_id, params, pose, view, loss))) return std::nullopt;
  BundleState state{.params = params, .camera_from_board = {pose}};
  std::vector<int> all(params.size());
  std::iota(all.begin(), all.end(), 0);
  const BundleSummary summary = solveBundle(model_id, std::span(&view, 1), state,
                                            {.loss = loss,
                                             .max_iterations = kMaxIterations,
                                             .function_tolerance = kCoarse,
                                             .constraint = {.held = std::move(all)}});
  if (summary.termination == Termination::kFailed) return std::nullopt;
  return state.camera_from_board.front();
}

bool improvePoses(std::string_view model_id, const Checkerboard& board, std::span<const View> views,
                  HuberLoss loss, PosedCamera& camera) {
  constexpr double kBetter = 0.99;  // of the cost: more than what a loose solve leaves
  const AnyCamera unprojector = AnyCamera::make(model_id, camera.params);
  const auto observations = observationsOf(board, views);
  bool is_improved = false;
  std::vector<double> costs(views.size(), std::numeric_limits<double>::infinity());
  const auto consider = [&](std::size_t v, const SE3& pose) {
    const double cost = viewCost(model_id, camera.params, pose, observations[v], loss);
    if (!(cost < kBetter * costs[v])) return;
    camera.poses[v] = pose;
    costs[v] = cost;
    is_improved = true;
  };
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (camera.poses[v])
      costs[v] = viewCost(model_id, camera.params, *camera.poses[v], observations[v], loss);
    if (const auto pose = poseFromView(unprojector, board, views[v].corners)) consider(v, *pose);
  }
  // A wrong tilt may have bent the camera to itself, so that its rays lead back to it.
  constexpr double kStandsOut = 4;  // times the median of all views
  const auto perCorner = [&](std::size_t v) {
    return costs[v] / static_cast<double>(observations[v].size());
  };
  std::vector<double> sorted;
  for (std::size_t v = 0; v < views.size(); ++v) sorted.push_back(perCorner(v));
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!camera.poses[v] || !(perCorner(v) > kStandsOut * *middle)) continue;
    const SE3 mirrored = mirroredTilt(*camera.poses[v], meanPoint(observations[v]));
    if (const auto pose = refinedPose(model_id, camera.params, mirrored, observations[v], loss))
      consider(v, *pose);
  }
  return is_improved;
}

std::optional<Start> startFrom(std::string_view model_id, std::vector<double> params,
                               const Checkerboard& board, std::span<const View> views) {
  Start start{.camera = {.params = std::move(params), .poses = {}}, .rivals = {}, .report = {}};
  start.camera.poses.resize(views.size());
  improvePoses(model_id, board, views, startLoss(views.front().size), start.camera);
  const auto num_posed = std::count_if(start.camera.poses.begin(), start.camera.poses.end(),
                                       [](const auto& pose) { return pose.has_value(); });
  if (static_cast<std::size_t>(num_posed) < kMinPosed) return std::nullopt;
  return start;
}

std::optional<Start> findStart(std::string_view model_id, const Checkerboard& board,
                               std::span<const View> views, const CancelFlag* cancel) {
  std::vector<std::size_t> chosen = spreadOf(views.size());
  const HuberLoss loss = startLoss(views.front().size);
  constexpr int kMaxRounds = 3;
  for (int round = 1;; ++round) {
    std::vector<View> some;
    for (const std::size_t v : chosen) some.push_back(views[v]);
    auto start = Search(board, std::move(some), cancel).run(model_id);
    if (!start) return std::nullopt;
    poseAll(model_id, board, views, chosen, loss, start->camera);
    for (PosedCamera& rival : start->rivals) poseAll(model_id, board, views, chosen, loss, rival);
    // A camera that was fitted to some views may fold where others have corners; those then join.
    std::vector<std::size_t> lacking;
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (!start->camera.poses[v] && !std::binary_search(chosen.begin(), chosen.end(), v))
        lacking.push_back(v);
    }
    if (lacking.empty() || round == kMaxRounds) return start;
    lacking.resize(std::min(lacking.size(), kMaxViews));
    chosen.insert(chosen.end(), lacking.begin(), lacking.end());
    std::sort(chosen.begin(), chosen.end());
  }
}

}  // namespace alidade
