// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bundle_adjustment.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <ceres/ceres.h>

#include "alidade/calibrate/bundle_problem.h"
#include "alidade/calibrate/view_kernel.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

// Ends Ceres' run where nothing is left to be won, and where it refuses a step: the poses are damped as the
// radius was when their Jacobian was evaluated, so a smaller radius takes a new one.
class StepWatch final : public ceres::IterationCallback {
 public:
  enum class End { kOpen, kSettled, kRefused };

  StepWatch(BundleProblem& bundle, const BundleOptions& options) : bundle_(bundle), options_(options) {}

  void begin() { end_ = End::kOpen; }
  [[nodiscard]] End end() const { return end_; }
  [[nodiscard]] int numSteps() const { return num_steps_; }

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& at) override {
    if (options_.cancel != nullptr && options_.cancel->load()) return ceres::SOLVER_ABORT;
    if (at.iteration > 0) ++num_steps_;
    if (!at.step_is_successful) {
      end_ = End::kRefused;
    } else if (bundle_.predictedDrop() <= options_.function_tolerance * bundle_.cost()) {
      end_ = End::kSettled;
    }
    return end_ == End::kOpen ? ceres::SOLVER_CONTINUE : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  BundleProblem& bundle_;
  const BundleOptions& options_;
  End end_ = End::kOpen;
  int num_steps_ = 0;
};

std::vector<ParamRange> rangesOf(std::string_view model_id) {
  std::vector<ParamRange> ranges(kAffineParamNames.size());
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if (M::kId == model_id) ranges.insert(ranges.end(), M::kLensRanges.begin(), M::kLensRanges.end());
  });
  return ranges;
}

// The end of the range that a value has come to, if any.
std::optional<double> endReached(const ParamRange& range, double value) {
  constexpr double kNear = 1e-6;  // lens parameters with a range are of the size of 1
  if (value - range.min < kNear) return range.min;
  if (range.max - value < kNear) return range.max;
  return std::nullopt;
}

Termination terminationOf(const ceres::Solver::Summary& summary) {
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
      return Termination::kConverged;
    case ceres::NO_CONVERGENCE:
      return Termination::kIterationLimit;
    default:
      return Termination::kFailed;
  }
}

// The problem and how Ceres is to solve it; refers to `state`, whose poses come back with takePoses().
class Bundle {
 public:
  Bundle(std::string_view model_id, std::span<const std::vector<Observation>> views, BundleState& state,
         const BundleOptions& options)
      : options_(options),
        state_(state),
        bundle_(model_id, views, options.loss, state.params, state.camera_from_board),
        watch_(bundle_, options) {
    bundle_.setPrior(options.prior);
    for (const auto& view : views) num_residuals_ += 2 * static_cast<double>(view.size());
    // By orthogonal transformations, which do not fail where parameters all but make up for each other.
    solver_.linear_solver_type = ceres::DENSE_QR;
    solver_.num_threads = 1;
    solver_.function_tolerance = options.function_tolerance;
    solver_.gradient_tolerance = 1e-10;
    solver_.parameter_tolerance = 1e-12;
    solver_.logging_type = ceres::SILENT;
    solver_.callbacks.push_back(&watch_);
  }

  BundleSummary solve(const ParamConstraint& constraint) {
    constexpr double kInitialRadius = 1e4;
    constexpr double kMinRadius = 1e-32;
    BundleSummary result;
    bundle_.constrain(constraint);
    const bool is_evaluable = bundle_.begin();
    result.cost = bundle_.cost();
    if (!is_evaluable) {
      result.reason = "A corner cannot be projected at the start.";
      return result;
    }
    const int num_steps_before = watch_.numSteps();
    double radius = kInitialRadius;
    double shrink = 2;
    while (radius > kMinRadius) {
      const int num_steps = watch_.numSteps();
      ceres::Solver::Summary summary = run(radius, options_.max_iterations - (num_steps - num_steps_before));
      result.termination = terminationOf(summary);
      result.reason = std::move(summary.message);
      if (watch_.end() != StepWatch::End::kRefused) break;
      // Each refusal in a row weighs more, as when Ceres goes on by itself.
      if (watch_.numSteps() - num_steps > 1) shrink = 2;
      radius = 2 * summary.iterations.back().trust_region_radius / shrink;
      shrink *= 2;
    }
    if (watch_.end() == StepWatch::End::kSettled) {
      result.termination = Termination::kConverged;
      result.reason = "Function tolerance reached by the model of the next step.";
    } else if (watch_.end() == StepWatch::End::kRefused) {
      // At the rounding of a perfect fit that is an optimum; elsewhere it is not known to be one.
      constexpr double kPerfect = 1e-12;  // px^2 a residual
      const bool is_perfect = bundle_.cost() <= kPerfect * num_residuals_;
      result.termination = is_perfect ? Termination::kConverged : Termination::kStalled;
      result.reason = "No step lowers the cost, however small.";
    }
    state_.params = bundle_.params();
    result.num_iterations = watch_.numSteps();
    result.cost = bundle_.cost();
    return result;
  }

  // Of the cost, by each parameter; nothing where a corner does not project.
  std::optional<Eigen::VectorXd> gradient() {
    if (!bundle_.begin()) return std::nullopt;
    return bundle_.gradient();
  }

  void takePoses() { state_.camera_from_board = bundle_.poses(); }

 private:
  ceres::Solver::Summary run(double radius, int max_iterations) {
    solver_.initial_trust_region_radius = radius;
    solver_.max_num_iterations = max_iterations;
    bundle_.setRadius(radius);
    watch_.begin();
    ceres::Solver::Summary summary;
    ceres::Solve(solver_, &bundle_.problem(), &summary);
    throwIfCancelled(options_.cancel);
    return summary;
  }

  const BundleOptions& options_;
  BundleState& state_;
  BundleProblem bundle_;
  StepWatch watch_;
  ceres::Solver::Options solver_;
  double num_residuals_ = 0;
};

// Solves again along the ends of ranges. Beyond them the lens has no value, the step is rejected whole, and
// the solver comes to rest where it first meets one. There the parameter is set to the end and held while
// the others go on, and let go where the cost then falls inwards (an active set). Ceres' own bounds cut the
// step off instead, which leads to the same optimum by thousands of steps.
void followRangeEnds(std::string_view model_id, BundleState& state, const ParamConstraint& constraint,
                     Bundle& bundle, BundleSummary& summary) {
  const std::vector<ParamRange> ranges = rangesOf(model_id);
  const int num_params = static_cast<int>(state.params.size());
  const auto isHeld = [](const std::vector<int>& set, int i) {
    return std::find(set.begin(), set.end(), i) != set.end();
  };
  for (int round = 0; round < num_params; ++round) {
    std::vector<int> at_limit = summary.at_limit;
    const std::vector<double> before = state.params;
    for (int i = 0; i < num_params; ++i) {
      const auto end =
          endReached(ranges[static_cast<std::size_t>(i)], state.params[static_cast<std::size_t>(i)]);
      if (!end || isHeld(constraint.held, i) || isHeld(at_limit, i)) continue;
      state.params[static_cast<std::size_t>(i)] = *end;
      at_limit.push_back(i);
    }
    const auto gradient = bundle.gradient();
    if (!gradient) {
      state.params = before;
      return;
    }
    std::erase_if(at_limit, [&](int i) {
      const auto at = static_cast<std::size_t>(i);
      const bool is_upper = state.params[at] == ranges[at].max;
      const double slope = (*gradient)(i);
      return is_upper ? slope > 0 : slope < 0;
    });
    if (at_limit == summary.at_limit) {
      state.params = before;
      return;
    }
    ParamConstraint all = constraint;
    all.held.insert(all.held.end(), at_limit.begin(), at_limit.end());
    summary = bundle.solve(all);
    summary.at_limit = std::move(at_limit);
  }
}

// Where to start again if the solver rests beside the end of a range and the optimum does not lie there:
// steps that would have led beyond were refused until none was left. Nothing if there is no such parameter.
std::optional<BundleState> fromFartherInside(std::string_view model_id, const BundleState& state,
                                             const ParamConstraint& constraint,
                                             const BundleSummary& summary) {
  constexpr double kBeside = 1e-4;
  constexpr double kInside = 0.2;
  const std::vector<ParamRange> ranges = rangesOf(model_id);
  BundleState inside = state;
  bool is_moved = false;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const int index = static_cast<int>(i);
    const auto has = [index](const std::vector<int>& set) {
      return std::find(set.begin(), set.end(), index) != set.end();
    };
    if (has(constraint.held) || has(summary.at_limit)) continue;
    if (state.params[i] > ranges[i].max - kBeside) {
      inside.params[i] = ranges[i].max - kInside;
    } else if (state.params[i] < ranges[i].min + kBeside) {
      inside.params[i] = ranges[i].min + kInside;
    } else {
      continue;
    }
    is_moved = true;
  }
  if (!is_moved) return std::nullopt;
  return inside;
}

BundleSummary solveAlongRanges(std::string_view model_id, std::span<const std::vector<Observation>> views,
                               BundleState& state, const BundleOptions& options) {
  Bundle bundle(model_id, views, state, options);
  BundleSummary summary = bundle.solve(options.constraint);
  if (summary.termination != Termination::kFailed)
    followRangeEnds(model_id, state, options.constraint, bundle, summary);
  bundle.takePoses();
  return summary;
}

}  // namespace

std::string_view terminationName(Termination termination) {
  switch (termination) {
    case Termination::kConverged:
      return "converged";
    case Termination::kIterationLimit:
      return "iteration_limit";
    case Termination::kStalled:
      return "stalled";
    case Termination::kFailed:
      return "failed";
  }
  return "unknown";
}

BundleSummary solveBundle(std::string_view model_id, std::span<const std::vector<Observation>> views,
                          BundleState& state, const BundleOptions& options) {
  BundleSummary summary = solveAlongRanges(model_id, views, state, options);
  if (summary.termination == Termination::kFailed) return summary;
  auto inside = fromFartherInside(model_id, state, options.constraint, summary);
  if (!inside) return summary;
  BundleSummary again = solveAlongRanges(model_id, views, *inside, options);
  if (again.termination != Termination::kConverged || !(again.cost < summary.cost)) return summary;
  state = *std::move(inside);
  again.num_iterations += summary.num_iterations;
  return again;
}

std::vector<Eigen::Vector2d> reprojectionErrors(std::string_view model_id, std::span<const double> params,
                                                const SE3& camera_from_board,
                                                std::span<const Observation> view) {
  std::vector<Eigen::Vector2d> errors(view.size());
  viewKernel(model_id).errors(params.data(), camera_from_board, CornerGroups(view).view(0), errors);
  return errors;
}

}  // namespace alidade
