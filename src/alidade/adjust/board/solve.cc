// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/solve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include <ceres/iteration_callback.h>
#include <ceres/ordered_groups.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/manifolds.h"
#include "alidade/adjust/board/view_block.h"
#include "alidade/camera/model_traits.h"

namespace alidade {
namespace {

// The plane through a point along given directions (orthogonal columns), for Ceres.
class LinearManifold final : public ceres::Manifold {
 public:
  explicit LinearManifold(Eigen::MatrixXd directions)
      : directions_(std::move(directions)),
        inverse_(directions_.colwise()
                     .squaredNorm()
                     .unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; })
                     .asDiagonal() *
                 directions_.transpose()) {}
  [[nodiscard]] int AmbientSize() const override { return static_cast<int>(directions_.rows()); }
  [[nodiscard]] int TangentSize() const override { return static_cast<int>(directions_.cols()); }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    Vector(x_plus_delta, AmbientSize()) =
        Eigen::Map<const Eigen::VectorXd>(x, AmbientSize()) +
        directions_ * Eigen::Map<const Eigen::VectorXd>(delta, TangentSize());
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<ViewFactor>(jacobian, AmbientSize(), TangentSize()) = directions_;
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    Vector(y_minus_x, TangentSize()) = inverse_ * (Eigen::Map<const Eigen::VectorXd>(y, AmbientSize()) -
                                                   Eigen::Map<const Eigen::VectorXd>(x, AmbientSize()));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<ViewFactor>(jacobian, TangentSize(), AmbientSize()) = inverse_;
    return true;
  }

 private:
  using Vector = Eigen::Map<Eigen::VectorXd>;

  Eigen::MatrixXd directions_;
  Eigen::MatrixXd inverse_;  // M x N
};

// Stops when the next step cannot reduce the cost further, and records the decrease that steps predict.
class StepWatch final : public ceres::IterationCallback {
 public:
  explicit StepWatch(const SolveOptions& options) : options_(options) {}

  // Predicted decrease, as a share of the cost, of the last step that earlier rejections did not shorten.
  [[nodiscard]] double promisedShare() const { return promised_share_; }
  [[nodiscard]] bool isRefused() const { return is_refused_; }

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& at) override {
    if (options_.cancel != nullptr && options_.cancel->load()) return ceres::SOLVER_ABORT;
    if (at.iteration == 0) {
      cost_ = at.cost;
      return ceres::SOLVER_CONTINUE;
    }
    // A trial at which a corner does not project has the largest possible cost and predicts no decrease.
    const bool is_evaluated = at.step_is_valid && at.cost < std::numeric_limits<double>::max();
    if (!is_refused_) promised_share_ = 1;
    if (!is_refused_ && is_evaluated) {
      // If costs differ only by rounding, the relative decrease may be zero.
      const double promised =
          at.relative_decrease == 0 ? std::abs(at.cost_change) : at.cost_change / at.relative_decrease;
      promised_share_ = promised / cost_;
      // Also true if NaN, when cost and predicted decrease are zero.
      if (!(promised > options_.function_tolerance * cost_)) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    is_refused_ = !at.step_is_successful;
    if (!is_refused_) cost_ = at.cost;
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const SolveOptions& options_;
  double cost_ = 0;  // cost after the last accepted step
  double promised_share_ = 1;
  bool is_refused_ = false;
};

// The fit in the form that Ceres needs.
class Bundle {
 public:
  Bundle(Fit& fit, const SolveOptions& options) : fit_(fit), options_(options) {
    ceres::Problem::Options problem;
    problem.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_ = std::make_unique<ceres::Problem>(problem);
    for (const FitCamera& camera : fit.cameras) rig_poses_.push_back(toBlock(camera.camera_from_rig));
    for (const FitBoard& board : fit.boards) {
      shapes_.push_back({board.shape.bend_x_m, board.shape.bend_y_m});
      body_poses_.push_back(toBlock(board.poseOf({})));
    }
    for (const FitPlacement& placement : fit.placements)
      placements_.push_back(toBlock(placement.rig_from_body));
    for (const FitView& view : fit.views)
      deviations_.push_back(view.deviation.value_or(PoseDeviation()).normal);
    for (std::size_t v = 0; v < fit.views.size(); ++v) add(v);
    for (FitCamera& camera : fit.cameras) {
      if (!problem_->HasParameterBlock(camera.params.data())) continue;
      const FoldGuard& guard = camera.weak_prior.guard;
      if (!guard.isNone())
        problem_->AddResidualBlock(foldGuardBlock(camera.model, guard), nullptr, camera.params.data());
      const LensPrior& prior = camera.weak_prior.prior;
      if (prior.isNone()) continue;
      const auto size = static_cast<Eigen::Index>(prior.precision.size());
      problem_->AddResidualBlock(
          priorBlock(Eigen::Map<const Eigen::VectorXd>(prior.precision.data(), size).cwiseSqrt(),
                     Eigen::Map<const Eigen::VectorXd>(prior.mean.data(), size)),
          nullptr, camera.params.data());
    }
    manifolds_.resize(fit.cameras.size());
  }

  // Restricts the intrinsics of a camera as the constraint demands.
  void constrain(std::size_t camera, const ParamConstraint& constraint) {
    double* params = fit_.cameras[camera].params.data();
    if (!problem_->HasParameterBlock(params)) return;
    problem_->SetManifold(params, nullptr);
    problem_->SetParameterBlockVariable(params);
    if (constraint.isNone()) return;
    Eigen::MatrixXd directions =
        freeDirections(static_cast<int>(fit_.cameras[camera].params.size()), constraint);
    if (directions.cols() == 0) {
      problem_->SetParameterBlockConstant(params);
      return;
    }
    manifolds_[camera] = std::make_unique<LinearManifold>(std::move(directions));
    problem_->SetManifold(params, manifolds_[camera].get());
  }

  SolveSummary solve() {
    SolveSummary result;
    if (!problem_->Evaluate({}, &result.cost, nullptr, nullptr, nullptr) || !std::isfinite(result.cost)) {
      result.cost = std::numeric_limits<double>::quiet_NaN();
      result.reason = "a corner cannot be projected at the start";
      return result;
    }
    StepWatch watch(options_);
    ceres::Solver::Options options = solverOptions();
    options.callbacks.push_back(&watch);
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem_.get(), &summary);
    throwIfCancelled(options_.cancel);
    result.num_iterations = static_cast<int>(summary.iterations.size()) - 1;
    result.cost = summary.final_cost;
    result.reason =
        summary.termination_type == ceres::USER_SUCCESS ? "steps no longer lower the cost" : summary.message;
    result.termination = terminationOf(summary, watch);
    return result;
  }

  // Gradient of the cost by the intrinsics of a camera, all free; nothing if a corner does not project. Zero
  // for a camera without views.
  [[nodiscard]] std::optional<std::vector<double>> gradient(std::size_t camera) {
    constrain(camera, {});
    ceres::Problem::EvaluateOptions only;
    only.parameter_blocks = {fit_.cameras[camera].params.data()};
    std::vector<double> gradient(fit_.cameras[camera].params.size());
    if (!problem_->HasParameterBlock(only.parameter_blocks[0])) return gradient;
    if (!problem_->Evaluate(only, nullptr, nullptr, &gradient, nullptr)) return std::nullopt;
    return gradient;
  }

  // Copies Ceres' blocks to the fit.
  void write() {
    for (std::size_t i = 0; i < rig_poses_.size(); ++i) {
      if (!fit_.cameras[i].is_rig_pose_fixed)
        fit_.cameras[i].camera_from_rig = fromBlock(rig_poses_[i].data());
    }
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      FitBoard& board = fit_.boards[i];
      if (board.isBodyPoseFree()) board.body_from_board = fromBlock(body_poses_[i].data());
      if (board.is_shape_fixed) continue;
      board.shape.bend_x_m = shapes_[i][0];
      board.shape.bend_y_m = shapes_[i][1];
    }
    for (std::size_t i = 0; i < placements_.size(); ++i)
      fit_.placements[i].rig_from_body = fromBlock(placements_[i].data());
    for (std::size_t v = 0; v < deviations_.size(); ++v) {
      if (fit_.views[v].deviation) fit_.views[v].deviation->normal = deviations_[v];
    }
  }

 private:
  void add(std::size_t v) {
    const FitView& view = fit_.views[v];
    auto block = std::make_unique<ViewBlock>(fit_, view);
    std::vector<double*> blocks = {fit_.cameras[view.camera].params.data(),
                                   placements_[view.placement].data()};
    if (block->hasRigPose()) blocks.push_back(rig_poses_[view.camera].data());
    if (block->hasBodyPose()) blocks.push_back(body_poses_[view.board].data());
    const std::vector<double*> poses(blocks.begin() + 1, blocks.end());
    if (block->hasShape()) blocks.push_back(shapes_[view.board].data());
    if (view.deviation) {
      blocks.push_back(deviations_[v].data());
      problem_->AddResidualBlock(priorBlock(PoseDeviation::Normal::Ones(), PoseDeviation::Normal::Zero()),
                                 nullptr, blocks.back());
      has_deviations_ = true;
      if (!fit_.cameras[view.camera].is_delay_fixed) blocks.push_back(&fit_.cameras[view.camera].delay);
    }
    num_residuals_ += 2 * static_cast<double>(view.corners.size());
    problem_->AddResidualBlock(block.release(), nullptr, blocks);
    for (double* pose : poses) problem_->SetManifold(pose, &pose_manifold_);
  }

  // Placements are eliminated first, because no view has two of them; or deviations, if there are any,
  // because no two views share one. Each other block has its own group, because Ceres orders blocks within a
  // group by address, and the order affects rounding.
  [[nodiscard]] ceres::Solver::Options solverOptions() {
    ceres::Solver::Options options;
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    bool has_shared = false;
    int group = 0;
    const auto append = [&](double* block, bool is_shared) {
      if (!problem_->HasParameterBlock(block)) return;
      ordering->AddElementToGroup(block, is_shared ? ++group : 0);
      has_shared = has_shared || (is_shared && !problem_->IsParameterBlockConstant(block));
    };
    for (PoseDeviation::Normal& deviation : deviations_) append(deviation.data(), false);
    for (PoseBlock& placement : placements_) append(placement.data(), has_deviations_);
    for (FitCamera& camera : fit_.cameras) append(camera.params.data(), true);
    for (PoseBlock& rig_pose : rig_poses_) append(rig_pose.data(), true);
    for (PoseBlock& body_pose : body_poses_) append(body_pose.data(), true);
    for (auto& shape : shapes_) append(shape.data(), true);
    for (FitCamera& camera : fit_.cameras) append(&camera.delay, true);
    // The sparse factorisation tolerates Schur complements that are nearly singular by rounding. The dense
    // one fails on them and reports it on standard error. Without shared unknowns, each placement is solved
    // separately.
    options.linear_solver_type = has_shared ? ceres::SPARSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
    if (has_shared) options.linear_solver_ordering = ordering;
    options.num_threads = 1;  // so that sums always have the same order
    options.max_num_iterations = options_.max_iterations;
    options.function_tolerance = options_.function_tolerance;
    options.gradient_tolerance = 1e-10;
    options.parameter_tolerance = 1e-12;
    options.max_num_consecutive_invalid_steps = 100;  // each step is smaller than the one before
    options.max_trust_region_radius = 1e12;           // keeps the remaining damping above rounding
    options.logging_type = ceres::SILENT;
    return options;
  }

  // If no step lowers the cost, Ceres stops because steps are small, which alone does not make an optimum.
  [[nodiscard]] Termination terminationOf(const ceres::Solver::Summary& summary,
                                          const StepWatch& watch) const {
    constexpr double kPerfect = 1e-12;  // px^2 per residual
    // Share of the cost that a step may predict without lowering it, for example at a kink of the loss.
    constexpr double kNegligible = 1e-10;
    const ceres::TerminationType end = summary.termination_type;
    if (end == ceres::NO_CONVERGENCE) return Termination::kIterationLimit;
    const bool is_success = end == ceres::CONVERGENCE || end == ceres::USER_SUCCESS;
    if (!is_success && end != ceres::FAILURE) return Termination::kFailed;
    const bool is_done = is_success && !watch.isRefused();
    const bool is_perfect = summary.final_cost <= kPerfect * num_residuals_;
    if (is_done || is_perfect || watch.promisedShare() <= kNegligible) return Termination::kConverged;
    return Termination::kStalled;
  }

  Fit& fit_;
  const SolveOptions& options_;
  SE3Manifold pose_manifold_;
  std::vector<std::unique_ptr<LinearManifold>> manifolds_;  // one per camera
  std::vector<PoseBlock> rig_poses_;
  std::vector<PoseBlock> body_poses_;  // of each board
  std::vector<PoseBlock> placements_;
  std::vector<PoseDeviation::Normal> deviations_;  // of each view
  bool has_deviations_ = false;
  std::vector<std::array<double, 2>> shapes_;
  std::unique_ptr<ceres::Problem> problem_;
  double num_residuals_ = 0;
};

// The limits of the lens parameters' ranges. Beyond them the lens has no value, a whole step is rejected, and
// the solver stops where it first meets a limit.
struct Range {
  FitParam param;
  ParamRange range;
};

std::vector<Range> freeRanges(const Fit& fit) {
  std::vector<Range> ranges;
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    const FitCamera& camera = fit.cameras[c];
    int index = static_cast<int>(kNumAffine);
    for (const ParamRange& range : modelTraits(camera.model).lens_ranges) {
      if (!camera.constraint.holds(index)) ranges.push_back({{c, index}, range});
      ++index;
    }
  }
  return ranges;
}

bool contains(const std::vector<FitParam>& params, FitParam param) {
  return std::ranges::find(params, param) != params.end();
}

double& valueOf(Fit& fit, FitParam param) {
  return fit.cameras[param.camera].params[static_cast<std::size_t>(param.index)];
}

// The limit of the range that a value has reached, if any.
std::optional<double> endReached(const ParamRange& range, double value) {
  constexpr double kNear = 1e-6;  // lens parameters with a range are of order 1
  if (value - range.min < kNear) return range.min;
  if (range.max - value < kNear) return range.max;
  return std::nullopt;
}

void constrainAll(Bundle& bundle, const Fit& fit, const std::vector<FitParam>& at_limit) {
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    ParamConstraint constraint = fit.cameras[c].constraint;
    for (const FitParam& param : at_limit) {
      if (param.camera == c) constraint.held.push_back(param.index);
    }
    bundle.constrain(c, constraint);
  }
}

// The parameters at a limit that the cost pushes against it; nothing if the cost cannot be evaluated.
std::optional<std::vector<FitParam>> pushedAgainstEnds(Bundle& bundle, Fit& fit,
                                                       std::span<const Range> ranges,
                                                       std::vector<FitParam> at_limit) {
  std::vector<std::vector<double>> gradients;
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    auto gradient = bundle.gradient(c);
    if (!gradient) return std::nullopt;
    gradients.push_back(std::move(*gradient));
  }
  for (const Range& r : ranges) {
    const double slope = gradients[r.param.camera][static_cast<std::size_t>(r.param.index)];
    const bool leads_inwards = valueOf(fit, r.param) == r.range.max ? slope > 0 : slope < 0;
    if (leads_inwards) std::erase(at_limit, r.param);
  }
  return at_limit;
}

// Active-set method: solves, fixes parameters that reach a limit of their range, solves for the others, and
// releases a parameter if the cost then falls inwards. Ceres' own bounds shorten steps instead, which takes
// thousands of steps to the same optimum.
SolveSummary solveAlongRanges(Fit& fit, std::span<const Range> ranges, const SolveOptions& options) {
  Bundle bundle(fit, options);
  constrainAll(bundle, fit, {});
  SolveSummary summary = bundle.solve();
  for (std::size_t round = 0; round < ranges.size(); ++round) {
    if (summary.termination == Termination::kFailed) break;
    std::vector<FitParam> at_limit = summary.at_limit;
    const std::vector<FitCamera> before = fit.cameras;
    for (const Range& r : ranges) {
      const auto end = endReached(r.range, valueOf(fit, r.param));
      if (!end || contains(at_limit, r.param)) continue;
      valueOf(fit, r.param) = *end;
      at_limit.push_back(r.param);
    }
    if (at_limit.empty()) break;
    const auto pushed = pushedAgainstEnds(bundle, fit, ranges, std::move(at_limit));
    if (!pushed || *pushed == summary.at_limit) {
      for (std::size_t c = 0; c < before.size(); ++c)
        std::copy(before[c].params.begin(), before[c].params.end(), fit.cameras[c].params.begin());
      break;
    }
    constrainAll(bundle, fit, *pushed);
    const int num_iterations = summary.num_iterations;
    summary = bundle.solve();
    summary.num_iterations += num_iterations;
    summary.at_limit = *pushed;
  }
  bundle.write();
  return summary;
}

// A new start for parameters that stopped near a limit although the optimum is elsewhere, because steps
// beyond the limit were rejected until none was left. Nothing if there are no parameters like these.
std::optional<Fit> fromFartherInside(const Fit& fit, std::span<const Range> ranges) {
  constexpr double kBeside = 1e-4;
  constexpr double kInside = 0.2;
  std::optional<Fit> inside;
  for (const Range& r : ranges) {
    if (contains(fit.summary.at_limit, r.param)) continue;
    const double value = fit.cameras[r.param.camera].params[static_cast<std::size_t>(r.param.index)];
    const bool is_high = value > r.range.max - kBeside;
    if (!is_high && !(value < r.range.min + kBeside)) continue;
    if (!inside) inside = fit;
    valueOf(*inside, r.param) = is_high ? r.range.max - kInside : r.range.min + kInside;
  }
  return inside;
}

}  // namespace

Fit solve(Fit fit, const SolveOptions& options) {
  const std::vector<Range> ranges = freeRanges(fit);
  fit.summary = solveAlongRanges(fit, ranges, options);
  if (fit.summary.termination != Termination::kFailed) {
    if (auto inside = fromFartherInside(fit, ranges)) {
      inside->summary = solveAlongRanges(*inside, ranges, options);
      if (inside->summary.termination == Termination::kConverged && inside->summary.cost < fit.summary.cost) {
        inside->summary.num_iterations += fit.summary.num_iterations;
        fit = *std::move(inside);
      }
    }
  }
  for (FitView& view : fit.views) view.errors = viewErrors(fit, view);
  return fit;
}

}  // namespace alidade
