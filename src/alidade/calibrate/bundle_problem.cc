// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bundle_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <ceres/cost_function.h>
#include <Eigen/QR>

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

// Parameter blocks: parameters, path. The shared rows, of which the last brings the sum of squares to the
// robust cost, and one for the path.
class BundleProblem::Cost final : public ceres::CostFunction {
 public:
  explicit Cost(const BundleProblem& bundle) : bundle_(bundle) {
    const int num_params = static_cast<int>(bundle.numParams());
    mutable_parameter_block_sizes()->push_back(num_params);
    mutable_parameter_block_sizes()->push_back(1);
    set_num_residuals(num_params + 2);
  }

  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    const Point& point = bundle_.is_at_base_ ? bundle_.base_ : bundle_.trial_;
    if (!point.is_evaluable) return false;
    const SharedRows& rows = bundle_.shared_rows_;
    const Eigen::Index num_params = rows.cols() - 1;
    Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
    if (jacobians == nullptr) {
      r.setZero();
      r(0) = std::sqrt(2 * point.cost());
      return true;
    }
    r << rows.rightCols<1>(), -bundle_.path_length_;
    if (jacobians[0] != nullptr) {
      Eigen::Map<RowMajorMatrix> J(jacobians[0], num_residuals(), num_params);
      J.topRows(rows.rows()) = rows.leftCols(num_params);
      J.bottomRows<1>().setZero();
    }
    if (jacobians[1] != nullptr)
      Eigen::Map<Eigen::VectorXd>(jacobians[1], num_residuals()) =
          Eigen::VectorXd::Unit(num_residuals(), num_residuals() - 1);
    return true;
  }

 private:
  const BundleProblem& bundle_;
};

BundleProblem::Point::Point(std::span<const double> at, std::span<const SE3> from)
    : params(at.begin(), at.end()),
      poses(from.begin(), from.end()),
      pose_rows(from.size() * PoseRowLayout::size(static_cast<int>(at.size()))),
      shared(at.size() + 1, at.size() + 1) {}

double BundleProblem::Point::cost() const {
  if (!is_evaluable) return std::numeric_limits<double>::quiet_NaN();
  return 0.5 * shared(shared.rows() - 1, shared.rows() - 1);
}

BundleProblem::BundleProblem(std::string_view model_id, std::span<const std::vector<Observation>> views,
                             HuberLoss loss, std::vector<double>& params, std::span<const SE3> poses)
    : kernel_(viewKernel(model_id)),
      elimination_(poseElimination(kernel_.numParams())),
      corners_(views),
      loss_(loss),
      params_(params),
      base_(params, poses),
      trial_(params, poses),
      factors_(base_.pose_rows.size()),
      shared_rows_(SharedRows::Zero(kernel_.numParams() + 1, kernel_.numParams() + 1)),
      directions_(freeDirections(kernel_.numParams(), {})),
      problem_(optionsWith(this)) {
  expect(views.size() == poses.size(), "one pose a view");
  expect(params.size() == static_cast<std::size_t>(kernel_.numParams()), "the model's parameters");
  problem_.AddResidualBlock(new Cost(*this), nullptr, params_.data(), &path_);
}

BundleProblem::~BundleProblem() = default;

void BundleProblem::constrain(const ParamConstraint& constraint) {
  problem_.SetManifold(params_.data(), nullptr);
  problem_.SetParameterBlockVariable(params_.data());
  directions_ = freeDirections(kernel_.numParams(), constraint);
  if (constraint.isNone()) return;
  if (directions_.cols() == 0) {
    problem_.SetParameterBlockConstant(params_.data());
    return;
  }
  params_manifold_ = std::make_unique<LinearManifold>(directions_);
  problem_.SetManifold(params_.data(), params_manifold_.get());
}

bool BundleProblem::begin() {
  base_.params = params_;
  base_.path = path_;
  is_eliminated_ = false;
  sum(base_);
  return base_.is_evaluable;
}

Eigen::VectorXd BundleProblem::gradient() const {
  const auto num_params = static_cast<Eigen::Index>(numParams());
  const auto num_poses = static_cast<Eigen::Index>(base_.poses.size());
  Eigen::VectorXd gradient(num_params + 6 * num_poses);
  gradient.head(num_params) = base_.shared.row(num_params).head(num_params);
  const std::size_t stride = PoseRowLayout::stride(kernel_.numParams());
  for (Eigen::Index i = 0; i < 6 * num_poses; ++i)
    gradient(num_params + i) =
        base_.pose_rows[static_cast<std::size_t>(i) * stride + PoseRowLayout::kShared + numParams()];
  return gradient;
}

double BundleProblem::predictedDrop() const {
  const Eigen::Index num_params = shared_rows_.cols() - 1;
  const Eigen::VectorXd y = shared_rows_.col(num_params).head(num_params);
  double square = y.squaredNorm();
  if (directions_.cols() == 0) {
    square = 0;
  } else if (directions_.cols() < num_params) {
    // Only what the directions span can be taken away.
    const Eigen::MatrixXd J = shared_rows_.topLeftCorner(num_params, num_params) * directions_;
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J);
    square = (qr.householderQ().adjoint() * y).head(qr.rank()).squaredNorm();
  }
  return 0.5 * (square + path_length_ * path_length_);
}

void BundleProblem::sum(Point& point) const {
  const std::size_t size = PoseRowLayout::size(kernel_.numParams());
  point.is_evaluable = true;
  point.shared.setZero();
  for (std::size_t v = 0; v < point.poses.size() && point.is_evaluable; ++v) {
    point.is_evaluable = kernel_.sum(point.params.data(), point.poses[v], corners_.view(v), loss_,
                                     point.pose_rows.data() + v * size, point.shared);
  }
  if (prior_ != nullptr) prior_->addTo(point.params, point.shared);
  point.is_evaluable = point.is_evaluable && point.shared.allFinite();
}

void BundleProblem::moveTrial() {
  trial_.params = params_;
  trial_.path = path_;
  std::vector<double> step(numParams());
  for (std::size_t i = 0; i < step.size(); ++i) step[i] = trial_.params[i] - base_.params[i];
  const double share = path_length_ > 0 ? (trial_.path - base_.path) / path_length_ : 0.0;
  elimination_.step(factors_, share, step, base_.poses, trial_.poses);
}

// As Ceres changes its radius for a step that it takes, so that the poses are damped alike: it asks for the
// Jacobian first and then changes it. Any other damping would lead to the same optimum.
double BundleProblem::radiusAfterTrial() const {
  constexpr double kMax = 1e16;
  const Eigen::Index num_params = shared_rows_.cols() - 1;
  const Eigen::VectorXd step = Eigen::Map<const Eigen::VectorXd>(trial_.params.data(), num_params) -
                               Eigen::Map<const Eigen::VectorXd>(base_.params.data(), num_params);
  const Eigen::VectorXd change = shared_rows_.leftCols(num_params) * step;
  const double path = trial_.path - base_.path;
  const double predicted =
      path * (path_length_ - 0.5 * path) - change.dot(shared_rows_.rightCols<1>() + 0.5 * change);
  const double quality = (base_.cost() - trial_.cost()) / predicted;
  return std::min(kMax, radius_ / std::max(1.0 / 3, 1 - std::pow(2 * quality - 1, 3)));
}

void BundleProblem::eliminate() {
  const Eigen::Index num_params = shared_rows_.cols() - 1;
  const double damping = 1 / (1 + radius_);
  SharedSums sums(kernel_.numParams());
  sums.gram = base_.shared;
  sums.diagonal = base_.shared.diagonal().head(num_params);
  elimination_.eliminate(base_.pose_rows, std::max(damping, kMinDamping), factors_, sums.gram);
  const double squared_length = base_.shared(num_params, num_params) - sums.gram(num_params, num_params);
  path_length_ = std::sqrt(std::max(squared_length, 0.0));
  // Ceres adds 1 / radius of the diagonal, and the elimination has made that smaller.
  for (Eigen::Index i = 0; i < num_params; ++i)
    sums.gram(i, i) += damping * std::max(sums.diagonal(i) - sums.gram(i, i), 0.0);
  base_.is_evaluable = base_.is_evaluable && sums.gram.allFinite();
  if (base_.is_evaluable) kernel_.factorize(sums, shared_rows_);
  is_eliminated_ = true;
}

void BundleProblem::PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) {
  if (new_evaluation_point) {
    is_at_base_ = !is_eliminated_ || (params_ == base_.params && path_ == base_.path);
    if (!is_at_base_) {
      moveTrial();
      sum(trial_);
    }
  }
  if (!evaluate_jacobians) return;
  if (!is_at_base_ && trial_.is_evaluable) {
    radius_ = radiusAfterTrial();
    std::swap(base_, trial_);
    is_at_base_ = true;
  }
  if (is_at_base_ && base_.is_evaluable) eliminate();
}

}  // namespace alidade
