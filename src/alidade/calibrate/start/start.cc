// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start/start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/board/view_pose.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/mapped.h"
#include "alidade/core/parallel.h"

namespace alidade {
namespace {

// A camera that may become the start.
struct StartCandidate : PosedCamera {
  double cost = 0;                    // including a charge for views without a pose
  std::optional<int> character = {};  // LensShape, if derived from the leading model's solution
  LensPrior prior = {};               // for the first solve
};

// With fewer posed views the result means nothing.
constexpr std::size_t kMinPosedViews = 3;

// Relative change of the cost at which intermediate solves stop.
constexpr double kCoarseTolerance = 1e-3;

constexpr int kMaxIterations = 100;
constexpr double kFine = 1e-6;  // relative change of the cost; enough to separate optima

constexpr std::size_t kMaxViews = 20;  // enough to choose a start; the others join in the full solve
constexpr std::size_t kMaxOptima = 3;  // compared on all views

// Accuracy that solves with this tolerance reach. Optima of two shapes may have nearly identical projections.
bool isSameLens(std::span<const double> a, std::span<const double> b) {
  constexpr double kRelative = 1e-2;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i] - b[i]) > kRelative * std::max({std::abs(a[i]), std::abs(b[i]), 1.0})) return false;
  }
  return true;
}

bool isCheaper(const StartCandidate& a, const StartCandidate& b) {
  return a.cost < b.cost;
}

std::vector<std::size_t> spreadOf(std::size_t num_views) {
  std::vector<std::size_t> some;
  const std::size_t count = std::min(kMaxViews, num_views);
  for (std::size_t i = 0; i < count; ++i) some.push_back(i * num_views / count);
  return some;
}

// The model whose solution the search begins with: the lead of the family, or the model itself if the lead
// contains it.
const ModelTraits& leadingModel(std::string_view model_id) {
  const ModelTraits& model = modelTraits(model_id);
  const ModelTraits& lead = leadTraits(model.family);
  return lead.extends(model_id) ? model : lead;
}

// Pixels per radian on the axis for several fields of view across the longer side.
std::vector<double> focalLengths(LensFamily family, ImageSize size) {
  const double half_side = 0.5 * std::max(size.width, size.height);
  const auto half = [](double fov_deg) { return 0.5 * fov_deg * std::numbers::pi / 180; };
  std::vector<double> focals;
  if (family == LensFamily::kWide) {
    for (const double fov : {15.0, 25.0, 40.0, 60.0, 90.0, 120.0, 150.0, 180.0, 210.0})
      focals.push_back(half_side / half(fov));
  } else {
    for (const double fov : {15.0, 25.0, 40.0, 60.0, 80.0, 100.0, 120.0})
      focals.push_back(half_side / std::tan(half(fov)));
  }
  return focals;
}

// Extends the solved poses of the chosen views to poses of all views.
void poseAll(std::string_view model_id, std::span<const std::vector<Observation>> views,
             std::span<const std::size_t> chosen, HuberLoss loss, PosedCamera& posed) {
  std::vector<std::optional<SE3>> poses(views.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) poses[chosen[i]] = posed.poses[i];
  posed.poses = std::move(poses);
  improvePoses(model_id, views, loss, posed);
}

// The search on a subset of the views.
class Search {
 public:
  // @param views  the corners of each view
  Search(ImageSize size, std::vector<std::vector<Observation>> views, const CalibratorOptions& options)
      : size_(size),
        views_(std::move(views)),
        loss_(startLoss(size)),
        jobs_(resolveJobs(options.jobs)),
        cancel_(options.cancel) {}

  std::optional<Start> run(std::string_view model_id) const {
    const std::string_view leading_id = leadingModel(model_id).id;
    std::vector<StartCandidate> candidates = hypotheses(leading_id);
    Start start;
    std::optional<StartCandidate> leading = solveBest(leading_id, candidates, start.report);
    if (!leading) return std::nullopt;
    if (leading_id == model_id) {
      start.optima.push_back(*std::move(leading));
      return start;
    }
    start.optima = reshape(leading_id, *leading, model_id);
    if (start.optima.empty()) return std::nullopt;
    start.report.num_optima = static_cast<int>(start.optima.size());
    return start;
  }

 private:
  // One camera per field of view that explains the views at all, the likeliest first.
  std::vector<StartCandidate> hypotheses(std::string_view model_id) const {
    std::vector<StartCandidate> candidates;
    for (const double focal : focalLengths(modelTraits(model_id).family, size_))
      candidates.push_back({{.params = startParameters(model_id, focal, size_), .poses = {}}});
    keepThose(candidates, [&](StartCandidate& candidate) {
      findPoses(model_id, candidate);
      return std::isfinite(candidate.cost);
    });
    std::ranges::stable_sort(candidates, isCheaper);
    return candidates;
  }

  // Solves candidates in order until two agree; returns the best. Spare threads solve later candidates
  // speculatively; these do not count.
  std::optional<StartCandidate> solveBest(std::string_view model_id, std::vector<StartCandidate>& candidates,
                                          StartReport& report) const {
    constexpr std::size_t kNeeded = 2;  // fewer cannot agree
    std::vector<StartCandidate> solved;
    std::size_t best = 0;
    report = {.num_tried = static_cast<int>(candidates.size())};
    std::size_t width = kNeeded;
    for (std::size_t first = 0; first < candidates.size();
         first += std::exchange(width, static_cast<std::size_t>(jobs_))) {
      const auto at = candidates.begin() + static_cast<std::ptrdiff_t>(first);
      const std::size_t count = std::min(width, candidates.size() - first);
      std::vector<StartCandidate> wave(at, at + static_cast<std::ptrdiff_t>(count));
      keepThose(wave, [&](StartCandidate& candidate) {
        return solveLeanly(model_id, candidate) && solve(model_id, candidate);
      });
      for (std::size_t i = 0; i < wave.size() && report.num_agreed < 2; ++i) {
        solved.push_back(std::move(wave[i]));
        if (solved.back().cost < solved[best].cost) best = solved.size() - 1;
        report.num_solved = static_cast<int>(solved.size());
        report.num_agreed = static_cast<int>(std::ranges::count_if(
            solved, [&](const auto& c) { return isSameOptimum(model_id, c, solved[best]); }));
      }
      if (report.num_agreed >= 2) break;
    }
    if (solved.empty()) return std::nullopt;
    return std::move(solved[best]);
  }

  // Goes from the solution of the leading model to those of the requested model: the best one, and all
  // distinct ones of about the same cost.
  std::vector<PosedCamera> reshape(std::string_view leading_id, const StartCandidate& leading,
                                   std::string_view model_id) const {
    std::vector<Eigen::Vector2d> pixels;
    for (const auto& view : views_) {
      constexpr std::size_t kEvery = 7;  // not a divisor of usual column counts of boards
      for (std::size_t i = 0; i < view.size(); i += kEvery) pixels.push_back(view[i].pixel);
    }
    const AnyCamera like = AnyCamera::make(leading_id, leading.params);
    std::vector<StartCandidate> shapes;
    const auto add = [&](std::vector<double> params) -> StartCandidate& {
      StartCandidate& shape = shapes.emplace_back();
      shape.params = std::move(params);
      shape.poses = leading.poses;
      return shape;
    };
    for (LensShape& shape : lensShapes(model_id, like, pixels))
      add(std::move(shape.params)).character = shape.character;
    // The model's own start, with a prior that keeps it nearby at first: where shapes merge into one another,
    // the solver would drift from other starts to a pole or out of range.
    const LensPrior prior = naturalPrior(model_id, like, leading);
    StartCandidate& plain = add({prior.mean.begin(), prior.mean.end()});
    std::copy_n(leading.params.begin() + 2, 2, plain.params.begin() + 2);
    plain.prior = prior;
    keepThose(shapes, [&](StartCandidate& shape) {
      if (shape.character) return solve(model_id, shape, kCoarseTolerance, {*shape.character});
      const bool is_near = shape.prior.isNone() || solve(model_id, shape, kCoarseTolerance, {}, shape.prior);
      return is_near && solve(model_id, shape);
    });
    if (shapes.empty()) return {};
    constexpr double kHopeless = 100;  // times the best cost; no shape recovers from there
    const double bound = kHopeless * std::ranges::min_element(shapes, {}, &StartCandidate::cost)->cost;
    std::erase_if(shapes, [&](const StartCandidate& shape) { return shape.cost > bound; });
    keepThose(shapes, [&](StartCandidate& shape) { return !shape.character || solve(model_id, shape); });
    std::ranges::stable_sort(shapes, isCheaper);
    std::vector<PosedCamera> optima;
    for (StartCandidate& shape : shapes) {
      constexpr double kRival = 1.2;  // times the best cost; the remaining views may reverse the order
      if (shape.cost > kRival * shapes.front().cost) break;
      const bool is_known = std::ranges::any_of(
          optima, [&](const PosedCamera& other) { return isSameLens(shape.params, other.params); });
      if (!is_known) optima.push_back(std::move(shape));
      if (optima.size() == kMaxOptima) break;
    }
    return optima;
  }

  // Works on the candidates in parallel, and removes those for which `work` fails.
  template <class Work>
  void keepThose(std::vector<StartCandidate>& candidates, Work&& work) const {
    std::vector<char> is_good(candidates.size());
    parallelFor(
        candidates.size(), jobs_, [&](std::size_t i) { is_good[i] = work(candidates[i]) ? 1 : 0; }, cancel_);
    std::size_t i = 0;
    std::erase_if(candidates, [&](const StartCandidate&) { return is_good[i++] == 0; });
  }

  // Computes poses from the corners' rays, and their cost; infinite if too few views can be posed.
  void findPoses(std::string_view model_id, StartCandidate& candidate) const {
    const AnyCamera camera = AnyCamera::make(model_id, candidate.params);
    candidate.poses.assign(views_.size(), std::nullopt);
    candidate.cost = 0;
    std::size_t num_posed = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const auto pose = poseFromCorners(camera, views_[v]);
      const double cost = pose ? viewCost(model_id, candidate.params, *pose, views_[v], loss_)
                               : std::numeric_limits<double>::quiet_NaN();
      if (std::isfinite(cost)) {
        candidate.poses[v] = pose;
        candidate.cost += cost;
        ++num_posed;
      } else {
        candidate.cost += missingViewCost(views_[v].size());
      }
    }
    if (num_posed < std::min(kMinPosedViews, views_.size()))
      candidate.cost = std::numeric_limits<double>::infinity();
  }

  // Solves only focal lengths, first distortion coefficient and poses. With more parameters free, views with
  // a wrong tilt would bias principal point and higher coefficients, and stay wrong. False on failure.
  bool solveLeanly(std::string_view model_id, StartCandidate& candidate) const {
    std::vector<int> held = {2, 3};
    for (int i = 5; i < static_cast<int>(candidate.params.size()); ++i) held.push_back(i);
    if (!solve(model_id, candidate, kCoarseTolerance, std::move(held))) return false;
    improvePoses(model_id, views_, loss_, candidate);
    return true;
  }

  // Solves until poses from rays no longer improve on the solved ones. False on failure.
  bool solve(std::string_view model_id, StartCandidate& candidate) const {
    constexpr int kMaxRounds = 3;
    for (int round = 0; round < kMaxRounds; ++round) {
      if (!solve(model_id, candidate, kFine, {})) return false;
      if (!improvePoses(model_id, views_, loss_, candidate)) break;
    }
    return true;
  }

  // Solves once, with parameters held or under a prior. False on failure.
  bool solve(std::string_view model_id, StartCandidate& candidate, double tolerance, std::vector<int> held,
             const LensPrior& prior = {}) const {
    // All boards are flat here; the corners carry their board positions.
    Fit fit = emptyFit(std::string(model_id), size_, candidate.params, Board(), loss_);
    onlyCamera(fit).constraint.held = std::move(held);
    onlyCamera(fit).weak_prior.prior = prior;
    double missing_cost = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (candidate.poses[v] &&
          std::isfinite(viewCost(model_id, candidate.params, *candidate.poses[v], views_[v], loss_))) {
        addView(fit, v, views_[v], *candidate.poses[v]);
      } else {
        candidate.poses[v].reset();
        missing_cost += missingViewCost(views_[v].size());
      }
    }
    if (fit.views.size() < kMinPosedViews) return false;
    fit = alidade::solve(
        std::move(fit),
        {.max_iterations = kMaxIterations, .function_tolerance = tolerance, .cancel = cancel_});
    // An iteration limit is not a failure here, because the full solve continues from this point.
    if (fit.summary.termination == Termination::kFailed || !hasFocalLengths(onlyCamera(fit))) return false;
    candidate.params = onlyCamera(fit).params;
    candidate.cost = missing_cost + fit.summary.cost;
    for (const FitView& view : fit.views) candidate.poses[view.source] = cameraFromBoard(fit, view);
    return true;
  }

  // The prior of natural sizes (LensScale) for a model initialised from a candidate of a different model,
  // with the candidate's noise.
  [[nodiscard]] LensPrior naturalPrior(std::string_view model_id, const AnyCamera& like,
                                       const StartCandidate& candidate) const {
    std::size_t num_corners = 0;
    for (std::size_t v = 0; v < views_.size(); ++v)
      if (candidate.poses[v]) num_corners += views_[v].size();
    const double variance = candidate.cost / static_cast<double>(std::max<std::size_t>(1, num_corners));
    return lensScale(model_id, like, size_).prior(1, variance);
  }

  // True if cost and projections of all corners agree.
  [[nodiscard]] bool isSameOptimum(std::string_view model_id, const StartCandidate& a,
                                   const StartCandidate& b) const {
    constexpr double kSameCost = 1e-4;
    constexpr double kSameErrors = 0.05;  // root mean square of the difference as a share of the errors
    if (std::abs(a.cost - b.cost) > kSameCost * std::min(a.cost, b.cost)) return false;
    double sum = 0;
    double sum_difference = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (a.poses[v].has_value() != b.poses[v].has_value()) return false;
      if (!a.poses[v]) continue;
      const auto errors_a = reprojectionErrors(model_id, a.params, *a.poses[v], views_[v]);
      const auto errors_b = reprojectionErrors(model_id, b.params, *b.poses[v], views_[v]);
      for (std::size_t i = 0; i < errors_a.size(); ++i) {
        sum += errors_a[i].squaredNorm();
        sum_difference += (errors_a[i] - errors_b[i]).squaredNorm();
      }
    }
    return sum_difference <= kSameErrors * kSameErrors * sum;
  }

  // Charge for a view without a pose: as if all its corners were far off. A bad start must not win by losing
  // views, and one bad view must not rule out every start.
  [[nodiscard]] double missingViewCost(std::size_t num_corners) const {
    constexpr double kFarOff = 10;  // thresholds of the loss
    const double error = kFarOff * loss_.threshold_px;
    return 0.5 * static_cast<double>(num_corners) * loss_.rho(error * error);
  }

  ImageSize size_;
  std::vector<std::vector<Observation>> views_;
  HuberLoss loss_;
  int jobs_;
  const CancelFlag* cancel_;
};

// The start at the initial camera.
std::optional<Start> givenStart(std::span<const std::vector<Observation>> views, ImageSize size,
                                const CalibratorOptions& options) {
  PosedCamera camera{.params = initialParameters(options, size), .poses = {}};
  camera.poses.resize(views.size());
  improvePoses(options.model, views, startLoss(size), camera);
  const auto num_posed =
      std::ranges::count_if(camera.poses, [](const auto& pose) { return pose.has_value(); });
  if (static_cast<std::size_t>(num_posed) < kMinPosedViews) return std::nullopt;
  return Start{.optima = {std::move(camera)}};
}

}  // namespace

std::optional<Start> findStart(std::span<const std::vector<Observation>> views, ImageSize size,
                               const CalibratorOptions& options) {
  if (options.initial) return givenStart(views, size, options);
  std::vector<std::size_t> chosen = spreadOf(views.size());
  const HuberLoss loss = startLoss(size);
  constexpr int kMostRounds = 3;
  for (int round = 1;; ++round) {
    auto some = mapped(chosen, [&](std::size_t v) { return views[v]; });
    auto start = Search(size, std::move(some), options).run(options.model);
    if (!start) return std::nullopt;
    for (PosedCamera& camera : start->optima) poseAll(options.model, views, chosen, loss, camera);
    // A camera fitted to some views may fold where others have corners; those are added.
    std::vector<std::size_t> lacking;
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (!start->optima.front().poses[v] && !std::ranges::binary_search(chosen, v)) lacking.push_back(v);
    }
    if (lacking.empty() || round == kMostRounds) return start;
    lacking.resize(std::min(lacking.size(), kMaxViews));
    chosen.insert(chosen.end(), lacking.begin(), lacking.end());
    std::ranges::sort(chosen);
  }
}

}  // namespace alidade
