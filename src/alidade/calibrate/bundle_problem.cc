// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bundle_problem.h"

#include <utility>

#include <ceres/cost_function.h>

#include "alidade/core/error.h"

namespace alidade {
namespace {

ceres::Problem::Options optionsWith(ceres::EvaluationCallback* callback) {
  ceres::Problem::Options options;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.evaluation_callback = callback;
  return options;
}

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

// Moves a pose as SE3Manifold does, but takes the first six columns of a Jacobian by the pose for those by
// its tangent, which the rows have at hand: there is no need to go there and back by the quaternion.
class BundleProblem::TangentManifold final : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override { return 7; }
  [[nodiscard]] int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    return se3_.Plus(x, delta, x_plus_delta);
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    return se3_.Minus(y, x, y_minus_x);
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>>(jacobian).setIdentity();
    return true;
  }

 private:
  SE3Manifold se3_;
};

// The rows of one view. Parameter blocks: parameters, pose.
class BundleProblem::PoseCost final : public ceres::CostFunction {
 public:
  PoseCost(const BundleProblem& bundle, std::size_t v) : bundle_(bundle), v_(v) {
    mutable_parameter_block_sizes()->push_back(bundle.kernel_.numParams());
    mutable_parameter_block_sizes()->push_back(7);
    set_num_residuals(6);
  }

  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    if (!bundle_.is_evaluable_) return false;
    const PoseRows& rows = bundle_.pose_rows_[v_];
    Eigen::Map<Eigen::Matrix<double, 6, 1>>{residuals} = rows.rightCols<1>();
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) {
      const int num_params = bundle_.kernel_.numParams();
      Eigen::Map<RowMajorMatrix>(jacobians[0], 6, num_params) = rows.middleCols(6, num_params);
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J_pose(jacobians[1]);
      J_pose << rows.leftCols<6>(), Eigen::Matrix<double, 6, 1>::Zero();
    }
    return true;
  }

 private:
  const BundleProblem& bundle_;
  std::size_t v_;
};

// What all views share. Parameter block: parameters.
class BundleProblem::SharedCost final : public ceres::CostFunction {
 public:
  explicit SharedCost(const BundleProblem& bundle) : bundle_(bundle) {
    mutable_parameter_block_sizes()->push_back(bundle.kernel_.numParams());
    set_num_residuals(bundle.kernel_.numParams() + 1);
  }

  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    if (!bundle_.is_evaluable_) return false;
    const SharedRows& rows = bundle_.shared_rows_;
    Eigen::Map<Eigen::VectorXd>(residuals, rows.rows()) = rows.rightCols<1>();
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<RowMajorMatrix>(jacobians[0], rows.rows(), rows.cols() - 1) = rows.leftCols(rows.cols() - 1);
    return true;
  }

 private:
  const BundleProblem& bundle_;
};

BundleProblem::BundleProblem(std::string_view model_id, std::span<const std::vector<Observation>> views,
                             HuberLoss loss, std::vector<double>& params, std::span<const SE3> poses)
    : kernel_(viewKernel(model_id)),
      corners_(views),
      loss_(loss),
      params_(params),
      pose_rows_(views.size(), PoseRows(6, kernel_.numParams() + 7)),
      shared_rows_(SharedRows::Zero(kernel_.numParams() + 1, kernel_.numParams() + 1)),
      pose_manifold_(std::make_unique<TangentManifold>()),
      problem_(optionsWith(this)) {
  expect(views.size() == poses.size(), "one pose a view");
  expect(params.size() == static_cast<std::size_t>(kernel_.numParams()), "the model's parameters");
  poses_.reserve(poses.size());
  for (const SE3& pose : poses) poses_.push_back(toBlock(pose));
  for (std::size_t v = 0; v < poses_.size(); ++v) {
    problem_.AddParameterBlock(poses_[v].data(), 7, pose_manifold_.get());
    problem_.AddResidualBlock(new PoseCost(*this, v), nullptr, params_.data(), poses_[v].data());
  }
  problem_.AddResidualBlock(new SharedCost(*this), nullptr, params_.data());
}

BundleProblem::~BundleProblem() = default;

void BundleProblem::constrain(const ParamConstraint& constraint) {
  problem_.SetManifold(params_.data(), nullptr);
  if (constraint.isNone()) return;
  Eigen::MatrixXd directions = freeDirections(kernel_.numParams(), constraint);
  // Ceres takes the cost of rows that hang on constants alone for constant, and the shared rows go on
  // changing with the poses. So the parameters stay variable, in a direction that moves none of them.
  if (directions.cols() == 0) directions = Eigen::MatrixXd::Zero(kernel_.numParams(), 1);
  params_manifold_ = std::make_unique<LinearManifold>(std::move(directions));
  problem_.SetManifold(params_.data(), params_manifold_.get());
}

ceres::ParameterBlockOrdering BundleProblem::ordering() {
  ceres::ParameterBlockOrdering ordering;
  for (PoseBlock& pose : poses_) ordering.AddElementToGroup(pose.data(), 0);
  ordering.AddElementToGroup(params_.data(), 1);
  return ordering;
}

void BundleProblem::PrepareForEvaluation(bool, bool new_evaluation_point) {
  if (!new_evaluation_point) return;
  is_evaluable_ = true;
  SharedSums sums(kernel_.numParams());
  for (std::size_t v = 0; v < poses_.size() && is_evaluable_; ++v) {
    is_evaluable_ = kernel_.reduce(params_.data(), pose(v), corners_.view(v), loss_, Unseen::kRefuse,
                                   pose_rows_[v], sums);
  }
  if (is_evaluable_ && prior_ != nullptr && !prior_->isNone()) prior_->addTo(params_.data(), sums);
  is_evaluable_ = is_evaluable_ && sums.gram.allFinite();
  if (is_evaluable_) kernel_.factorize(sums, shared_rows_);
}

}  // namespace alidade
