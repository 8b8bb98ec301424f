// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <ceres/evaluation_callback.h>
#include <ceres/problem.h>
#include <Eigen/Core>

#include "alidade/calibrate/corner_groups.h"
#include "alidade/calibrate/lens_prior.h"
#include "alidade/calibrate/param_constraint.h"
#include "alidade/calibrate/pose_elimination.h"
#include "alidade/calibrate/view_kernel.h"

namespace alidade {

/// The robust fit of intrinsics and poses as Ceres sees it: few unknowns and few rows, because the solver's
/// time goes with their number. The poses are none of them. They are eliminated from the normal equations of
/// the corners, which are summed view by view, and follow by back substitution.
///
/// From a point, which is parameters and poses, the unknowns lead to others: the step of the parameters dp,
/// and how far the poses go the way that is theirs alone. The pose of view v steps by
///   -(A_v + damping D_v)^-1 (g_v s + B_v dp),
/// where A_v, B_v and g_v are its parts of J^T J and J^T r and D_v is the diagonal of A_v. With the damping
/// that belongs to the radius of the trust region, s = 1 and the dp that minimises what the elimination
/// leaves are the step of Levenberg and Marquardt's method for all unknowns together. The unknown is not s
/// but s times the root of the sum of g_v^T (A_v + damping D_v)^-1 g_v, which is in pixels, as far as poses
/// alone move corners to first order. It adds up over the steps.
///
/// Cost and gradient are exact at every point and for every step. J^T J has the damping of the poses in it.
///
/// A point that is tried is most often taken: its normal equations are summed together with its cost.
class BundleProblem final : public ceres::EvaluationCallback {
 public:
  /// Changes `params` while it is solved.
  BundleProblem(std::string_view model_id, std::span<const std::vector<Observation>> views, HuberLoss loss,
                std::vector<double>& params, std::span<const SE3> poses);
  BundleProblem(const BundleProblem&) = delete;
  BundleProblem& operator=(const BundleProblem&) = delete;
  ~BundleProblem() override;

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

  [[nodiscard]] ceres::Problem& problem() { return problem_; }
  /// The unknowns: `params`, and the way of the poses.
  [[nodiscard]] double* path() { return &path_; }
  /// Adds a prior to the cost, before begin(); refers to it.
  void setPrior(const LensPrior& prior) { prior_ = &prior; }
  /// Lets the parameters move only as the constraint says; none of them may be left.
  void constrain(const ParamConstraint& constraint);
  /// Starts at the parameters as they are now and the poses as they have become. False if a corner does not
  /// project there; then there is nothing to solve.
  [[nodiscard]] bool begin();
  /// Of the trust region, for the next evaluation of a Jacobian.
  void setRadius(double radius) { radius_ = radius; }

  /// What the unknowns have come to, where the last Jacobian was evaluated.
  [[nodiscard]] const std::vector<double>& params() const { return base_.params; }
  [[nodiscard]] const std::vector<SE3>& poses() const { return base_.poses; }
  [[nodiscard]] double cost() const { return base_.cost(); }  ///< NaN if a corner does not project
  /// By how much the damped model falls until its minimum.
  [[nodiscard]] double predictedDrop() const;

  /// Of the cost by the parameters, then by the tangent of each pose; after begin().
  [[nodiscard]] Eigen::VectorXd gradient() const;

 private:
  class Cost;

  // Normal equations at some parameters and poses.
  struct Point {
    Point(std::span<const double> at, std::span<const SE3> poses);
    [[nodiscard]] double cost() const;
    std::vector<double> params;
    double path = 0;
    std::vector<SE3> poses;
    bool is_evaluable = false;
    std::vector<double> pose_rows;  // of all views
    Eigen::MatrixXd shared;         // columns of parameters and error, lower triangle
  };

  [[nodiscard]] std::size_t numParams() const { return params_.size(); }
  void sum(Point& point) const;
  void moveTrial();
  [[nodiscard]] double radiusAfterTrial() const;
  void eliminate();

  const ViewKernel& kernel_;
  const PoseElimination& elimination_;
  CornerGroups corners_;
  HuberLoss loss_;
  const LensPrior* prior_ = nullptr;
  std::vector<double>& params_;
  double path_ = 0;

  Point base_;
  Point trial_;
  bool is_at_base_ = true;  // the point of the latest evaluation

  // From the base.
  double radius_ = 0;
  bool is_eliminated_ = false;
  std::vector<double> factors_;
  double path_length_ = 0;  // of a whole step
  SharedRows shared_rows_;

  Eigen::MatrixXd directions_;                        // that a constraint leaves
  std::unique_ptr<ceres::Manifold> params_manifold_;  // of a constraint
  ceres::Problem problem_;
};

}  // namespace alidade
