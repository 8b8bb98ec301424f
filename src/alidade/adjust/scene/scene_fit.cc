// SPDX-License-Identifier: MIT
#include "alidade/adjust/scene/scene_fit.h"

#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <ceres/iteration_callback.h>
#include <ceres/loss_function.h>
#include <ceres/ordered_groups.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>
#include <ceres/sphere_manifold.h>

#include "alidade/adjust/board/manifolds.h"

namespace alidade {
namespace {

// Its parameter blocks are the pose, the point and, if images have an error field, its coefficients.
class SightingBlock final : public ceres::CostFunction {
 public:
  SightingBlock(const SceneFit& fit, const SceneSighting& sighting)
      : camera_(fit.camera),
        target_(sighting.pixel - fit.readout * sighting.readout_px),
        scale_(1 / sighting.sigma_px),
        has_field_(fit.field_px > 0) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {7, 4};
    if (!has_field_) return;
    mutable_parameter_block_sizes()->push_back(ErrorField::kSize);
    basis_ = ErrorField::basisAt(sighting.pixel, fit.size);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const SE3 pose = fromBlock(blocks[0]);
    const PointInCamera p = inCamera(pose, Eigen::Map<const Eigen::Vector4d>(blocks[1]));
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
    const bool is_derived = jacobians != nullptr;
    const Projection projection = camera_.project(p.at, is_derived ? J_px_cam.data() : nullptr);
    if (!projection.ok()) return false;
    Eigen::Vector2d error = projection.pixel - target_;
    if (has_field_) error += ErrorField::at(basis_, Eigen::Map<const ErrorField::Coefficients>(blocks[2]));
    Eigen::Map<Eigen::Vector2d>{residuals} = scale_ * error;
    if (!is_derived) return true;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>>{jacobians[0]} =
          scale_ * (J_px_cam * p.J_pose) * tangentByBlock(blocks[0]);
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 4, Eigen::RowMajor>>{jacobians[1]} = scale_ * J_px_cam * p.J_point;
    }
    if (has_field_ && jacobians[2] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, ErrorField::kSize, Eigen::RowMajor>> J(jacobians[2]);
      J.setZero();
      J.block<1, ErrorField::kTerms>(0, 0) = scale_ * basis_.transpose();
      J.block<1, ErrorField::kTerms>(1, ErrorField::kTerms) = scale_ * basis_.transpose();
    }
    return true;
  }

 private:
  const AnyCamera& camera_;
  Eigen::Vector2d target_;
  double scale_;
  bool has_field_;
  ErrorField::Basis basis_;
};

// Holds the free scale by the distance of one frame from the first, which does not affect pixels.
class DistanceHold final : public ceres::SizedCostFunction<1, 7> {
 public:
  DistanceHold(const Eigen::Vector3d& first, double distance) : first_(first), distance_(distance) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const SE3 pose = fromBlock(blocks[0]);
    const Eigen::Vector3d at = pose * first_;
    residuals[0] = kWeight * (at.norm() / distance_ - 1);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Matrix<double, 1, 6> J;
    J.head<3>() = kWeight / distance_ * at.normalized().transpose() * pose.rotation.matrix();
    J.tail<3>() = -J.head<3>() * hat(first_);
    Eigen::Map<Eigen::Matrix<double, 1, 7>>{jacobians[0]} = J * tangentByBlock(blocks[0]);
    return true;
  }

 private:
  static constexpr double kWeight = 100;
  Eigen::Vector3d first_;
  double distance_;
};

// Only checks the flag; Ceres' own rules decide when to stop.
class CancelWatch final : public ceres::IterationCallback {
 public:
  explicit CancelWatch(const CancelFlag* cancel) : cancel_(cancel) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return cancel_ != nullptr && cancel_->load() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const CancelFlag* cancel_;
};

// If the scale is free, holds it by the distance of the frame that is farthest from the first one.
void holdScale(ceres::Problem& problem, const SceneFit& fit, std::vector<PoseBlock>& poses) {
  const Eigen::Vector3d first = fit.camera_from_world.front().inverse().translation;
  std::size_t farthest = 0;
  double distance = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double d = (fit.camera_from_world[i] * first).norm();
    if (d <= distance) continue;
    distance = d;
    farthest = i;
  }
  if (fit.num_held_frames > 1 || distance == 0 || !problem.HasParameterBlock(poses[farthest].data())) return;
  problem.AddResidualBlock(new DistanceHold(first, distance), nullptr, poses[farthest].data());
}

ceres::Solver::Options sceneSolverOptions(const SolveOptions& options) {
  ceres::Solver::Options solver;
  solver.num_threads = 1;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = 1e-10;
  solver.parameter_tolerance = 1e-10;
  solver.max_num_consecutive_invalid_steps = 50;
  // Damping holds points without parallax, and must stay above the rounding of their elimination. With more
  // damping, scenes converge slowly along their long valleys.
  solver.max_trust_region_radius = 1e7;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace

ErrorField::Basis ErrorField::basisAt(const Eigen::Vector2d& pixel, const ImageSize& size) {
  const double x = (2 * pixel.x() + 1) / size.width - 1;
  const double y = (2 * pixel.y() + 1) / size.height - 1;
  Basis basis;
  basis << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  return basis;
}

PointInCamera inCamera(const SE3& camera_from_world, const Eigen::Vector4d& point) {
  const Eigen::Matrix3d R = camera_from_world.rotation.matrix();
  PointInCamera p;
  p.J_point << R, camera_from_world.translation;
  p.at = p.J_point * point;
  p.J_pose << R * point.w(), -R * hat(point.head<3>());
  return p;
}

SceneProjection projectSighting(const SceneFit& fit, const SceneSighting& sighting) {
  SceneProjection result;
  const PointInCamera p = inCamera(fit.camera_from_world[sighting.frame], fit.points[sighting.point]);
  const auto num_params = static_cast<Eigen::Index>(fit.camera.parameters().size());
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor, 2, 24> J_params(2, num_params);
  const Projection projection = fit.camera.project(p.at, J_px_cam.data(), J_params.data());
  if (!projection.ok()) return result;
  result.ok = true;
  result.error = projection.pixel + fit.readout * sighting.readout_px - sighting.pixel;
  result.J_pose = J_px_cam * p.J_pose;
  result.J_point = J_px_cam * p.J_point;
  result.J_params = J_params;
  if (fit.field_px > 0) {
    result.field = ErrorField::basisAt(sighting.pixel, fit.size);
    result.error += ErrorField::at(result.field, fit.fields[sighting.frame]);
  }
  return result;
}

Eigen::Vector2d sightingError(const SceneFit& fit, const SceneSighting& sighting) {
  const Eigen::Vector4d& point = fit.points[sighting.point];
  const SE3& pose = fit.camera_from_world[sighting.frame];
  const Projection projection =
      fit.camera.project(pose.rotation * Eigen::Vector3d(point.head<3>()) + pose.translation * point.w());
  Eigen::Vector2d error = projection.pixel + fit.readout * sighting.readout_px - sighting.pixel;
  if (fit.field_px > 0)
    error += ErrorField::at(ErrorField::basisAt(sighting.pixel, fit.size), fit.fields[sighting.frame]);
  return error;
}

SceneFit solveScene(SceneFit fit, const SolveOptions& options) {
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.enable_fast_removal = false;
  ceres::Problem problem(problem_options);
  SE3Manifold pose_manifold;
  ceres::SphereManifold<4> point_manifold;
  std::unique_ptr<ceres::LossFunction> loss;
  if (std::isfinite(fit.loss.threshold_px)) loss = std::make_unique<ceres::HuberLoss>(fit.loss.threshold_px);

  std::vector<PoseBlock> poses;
  for (const SE3& pose : fit.camera_from_world) poses.push_back(toBlock(pose));
  for (const SceneSighting& sighting : fit.sightings) {
    std::vector<double*> blocks = {poses[sighting.frame].data(), fit.points[sighting.point].data()};
    if (fit.field_px > 0) blocks.push_back(fit.fields[sighting.frame].data());
    problem.AddResidualBlock(new SightingBlock(fit, sighting), loss.get(), blocks);
  }
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (Eigen::Vector4d& point : fit.points) {
    if (!problem.HasParameterBlock(point.data())) continue;
    problem.SetManifold(point.data(), &point_manifold);
    ordering->AddElementToGroup(point.data(), 0);
  }
  bool has_free_pose = false;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!problem.HasParameterBlock(poses[i].data())) continue;
    // A separate group for each block, because Ceres orders blocks within a group by address, and the order
    // affects rounding.
    ordering->AddElementToGroup(poses[i].data(), static_cast<int>(i) + 1);
    problem.SetManifold(poses[i].data(), &pose_manifold);
    if (i < fit.num_held_frames) problem.SetParameterBlockConstant(poses[i].data());
    has_free_pose = has_free_pose || i >= fit.num_held_frames;
    if (fit.field_px == 0) continue;
    problem.AddResidualBlock(
        priorBlock(ErrorField::Coefficients::Constant(1 / fit.field_px), ErrorField::Coefficients::Zero()),
        nullptr, fit.fields[i].data());
    ordering->AddElementToGroup(fit.fields[i].data(), static_cast<int>(poses.size() + i) + 1);
  }
  holdScale(problem, fit, poses);

  double cost = 0;
  const bool is_evaluable = problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
  if (!is_evaluable || !std::isfinite(cost)) {
    fit.summary = {.reason = "a point cannot be projected at the start",
                   .cost = std::numeric_limits<double>::quiet_NaN()};
    return fit;
  }
  ceres::Solver::Options solver = sceneSolverOptions(options);
  // Same as in solve(): the dense factorisation fails if rounding makes the free direction of the scale
  // singular.
  solver.linear_solver_type = has_free_pose ? ceres::SPARSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
  if (has_free_pose) solver.linear_solver_ordering = ordering;
  CancelWatch watch(options.cancel);
  solver.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  throwIfCancelled(options.cancel);

  for (std::size_t i = fit.num_held_frames; i < poses.size(); ++i)
    fit.camera_from_world[i] = fromBlock(poses[i].data());
  fit.summary = {.reason = summary.message,
                 .num_iterations = static_cast<int>(summary.iterations.size()) - 1,
                 .cost = summary.final_cost};
  const ceres::TerminationType end = summary.termination_type;
  fit.summary.termination = end == ceres::CONVERGENCE || end == ceres::USER_SUCCESS ? Termination::kConverged
                            : end == ceres::NO_CONVERGENCE ? Termination::kIterationLimit
                                                           : Termination::kFailed;
  return fit;
}

}  // namespace alidade
