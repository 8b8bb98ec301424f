// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bundle_adjustment.h"

#include <algorithm>
#include <memory>
#include <optional>

#include <ceres/ceres.h>

#include "alidade/calibrate/bundle_problem.h"
#include "alidade/calibrate/view_kernel.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

class CancelCallback final : public ceres::IterationCallback {
 public:
  explicit CancelCallback(const CancelFlag* cancel) : cancel_(cancel) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return cancel_ != nullptr && cancel_->load() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const CancelFlag* cancel_;
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

// Ceres also calls it convergence when no step however small lowers the cost. At the rounding of a perfect
// fit that is an optimum; elsewhere it is not known to be one.
bool isStalled(const ceres::Solver::Summary& summary) {
  constexpr double kPerfect = 1e-12;  // px^2 a residual
  return summary.message.find("trust region radius") != std::string::npos &&
         summary.final_cost > kPerfect * summary.num_residuals;
}

Termination terminationOf(const ceres::Solver::Summary& summary) {
  switch (summary.termination_type) {
    case ceres::CONVERGENCE:
      return isStalled(summary) ? Termination::kStalled : Termination::kConverged;
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
        cancel_(options.cancel) {
    bundle_.setPrior(options.prior);
    solver_.linear_solver_type = ceres::DENSE_SCHUR;
    solver_.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>(bundle_.ordering());
    solver_.num_threads = 1;
    solver_.max_num_iterations = options.max_iterations;
    solver_.function_tolerance = options.function_tolerance;
    solver_.gradient_tolerance = 1e-10;
    solver_.parameter_tolerance = 1e-12;
    solver_.logging_type = ceres::SILENT;
    solver_.callbacks.push_back(&cancel_);
  }

  BundleSummary solve(const ParamConstraint& constraint) {
    bundle_.constrain(constraint);
    ceres::Solver::Summary summary;
    ceres::Solve(solver_, &bundle_.problem(), &summary);
    throwIfCancelled(options_.cancel);
    num_iterations_ += summary.num_successful_steps + summary.num_unsuccessful_steps;
    BundleSummary result;
    result.termination = terminationOf(summary);
    result.reason = summary.message;
    result.num_iterations = num_iterations_;
    result.cost = summary.final_cost;
    return result;
  }

  // Of the cost, by each parameter; nothing where a corner does not project.
  std::optional<std::vector<double>> gradient() {
    bundle_.constrain({});
    ceres::Problem::EvaluateOptions evaluate;
    evaluate.parameter_blocks = {state_.params.data()};
    std::vector<double> gradient;
    if (!bundle_.problem().Evaluate(evaluate, nullptr, nullptr, &gradient, nullptr)) return std::nullopt;
    return gradient;
  }

  void takePoses() {
    for (std::size_t v = 0; v < state_.camera_from_board.size(); ++v)
      state_.camera_from_board[v] = bundle_.pose(v);
  }

 private:
  const BundleOptions& options_;
  BundleState& state_;
  BundleProblem bundle_;
  CancelCallback cancel_;
  ceres::Solver::Options solver_;
  int num_iterations_ = 0;
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
      return is_upper ? (*gradient)[at] > 0 : (*gradient)[at] < 0;
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
  Bundle bundle(model_id, views, state, options);
  BundleSummary summary = bundle.solve(options.constraint);
  if (summary.termination != Termination::kFailed)
    followRangeEnds(model_id, state, options.constraint, bundle, summary);
  bundle.takePoses();
  return summary;
}

std::vector<Eigen::Vector2d> reprojectionErrors(std::string_view model_id, std::span<const double> params,
                                                const SE3& camera_from_board,
                                                std::span<const Observation> view) {
  std::vector<Eigen::Vector2d> errors(view.size());
  viewKernel(model_id).errors(params.data(), camera_from_board, CornerGroups(view).view(0), errors);
  return errors;
}

}  // namespace alidade
