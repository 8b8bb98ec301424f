// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <ceres/evaluation_callback.h>
#include <ceres/ordered_groups.h>
#include <ceres/problem.h>

#include "alidade/calibrate/corner_groups.h"
#include "alidade/calibrate/lens_prior.h"
#include "alidade/calibrate/param_constraint.h"
#include "alidade/calibrate/se3_manifold.h"
#include "alidade/calibrate/view_kernel.h"

namespace alidade {

/// The robust fit of intrinsics and poses in as few rows as hold it, because the solver's time goes with
/// their number: all corners are summed into normal equations [J r]^T [J r], view by view, and these are
/// factorized again.
///
/// Six rows a view hold what its pose takes part in. What is left of the intrinsics' columns is summed over
/// the views and gives as many rows as there are intrinsics. All together have the gradient and the
/// Gauss-Newton matrix of the corners' own rows. One more row, whose Jacobian is zero, brings the sum of
/// squares to the robust cost, the sum of rho.
///
/// A point that is tried is most often taken: its Jacobian is summed together with its cost.
class BundleProblem final : public ceres::EvaluationCallback {
 public:
  /// Changes `params` and its own copies of the poses while it is solved.
  BundleProblem(std::string_view model_id, std::span<const std::vector<Observation>> views, HuberLoss loss,
                std::vector<double>& params, std::span<const SE3> poses);
  BundleProblem(const BundleProblem&) = delete;
  BundleProblem& operator=(const BundleProblem&) = delete;
  ~BundleProblem() override;

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

  [[nodiscard]] ceres::Problem& problem() { return problem_; }
  /// Adds a prior to the cost; refers to it.
  void setPrior(const LensPrior& prior) { prior_ = &prior; }
  /// Lets the parameters move only as the constraint says; none of them may be left.
  void constrain(const ParamConstraint& constraint);
  /// Poses before the parameters, for the Schur complement.
  [[nodiscard]] ceres::ParameterBlockOrdering ordering();
  [[nodiscard]] SE3 pose(std::size_t v) const { return fromBlock(poses_[v].data()); }

 private:
  class TangentManifold;
  class PoseCost;
  class SharedCost;

  const ViewKernel& kernel_;
  CornerGroups corners_;
  HuberLoss loss_;
  const LensPrior* prior_ = nullptr;
  std::vector<double>& params_;
  std::vector<PoseBlock> poses_;

  // Of the latest evaluation.
  bool is_evaluable_ = false;
  std::vector<PoseRows> pose_rows_;  // a view's
  SharedRows shared_rows_;

  std::unique_ptr<ceres::Manifold> pose_manifold_;
  std::unique_ptr<ceres::Manifold> params_manifold_;  // of a constraint
  ceres::Problem problem_;
};

}  // namespace alidade
