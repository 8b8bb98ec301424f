// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bundle_adjustment.h"

#include <memory>

#include <ceres/ceres.h>

#include "alidade/calibrate/bundle_problem.h"
#include "alidade/calibrate/view_kernel.h"

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
  BundleProblem bundle(model_id, views, options.loss, state.params, state.camera_from_board);

  CancelCallback cancel(options.cancel);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>(bundle.ordering());
  solver.num_threads = 1;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = 1e-10;
  solver.parameter_tolerance = 1e-12;
  solver.logging_type = ceres::SILENT;
  solver.callbacks.push_back(&cancel);

  ceres::Solver::Summary summary;
  ceres::Solve(solver, &bundle.problem(), &summary);
  throwIfCancelled(options.cancel);

  for (std::size_t i = 0; i < views.size(); ++i) state.camera_from_board[i] = bundle.pose(i);
  BundleSummary result;
  result.termination = terminationOf(summary);
  result.reason = summary.message;
  result.num_iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
  result.cost = summary.final_cost;
  return result;
}

std::vector<Eigen::Vector2d> reprojectionErrors(std::string_view model_id, std::span<const double> params,
                                                const SE3& camera_from_board,
                                                std::span<const Observation> view) {
  std::vector<Eigen::Vector2d> errors(view.size());
  viewKernel(model_id).errors(params.data(), camera_from_board, CornerGroups(view).view(0), errors);
  return errors;
}

}  // namespace alidade
