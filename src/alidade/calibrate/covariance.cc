// SPDX-License-Identifier: MIT
#include "alidade/calibrate/covariance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "alidade/calibrate/corner_groups.h"
#include "alidade/calibrate/view_kernel.h"

namespace alidade {
IntrinsicsInformation intrinsicsInformation(std::string_view model_id,
                                            std::span<const std::vector<Observation>> views,
                                            const BundleState& state, const ParamConstraint& constraint) {
  IntrinsicsInformation result;
  // The poses' Schur complement of J^T W J is that of a fit without a loss.
  const ViewKernel& kernel = viewKernel(model_id);
  const CornerGroups corners(views);
  SharedSums sums(kernel.numParams());
  PoseRows rows(6, kernel.numParams() + 7);
  for (std::size_t v = 0; v < views.size(); ++v) {
    static_cast<void>(kernel.reduce(state.params.data(), state.camera_from_board[v], corners.view(v), kNoLoss,
                                    Unseen::kLeaveOut, rows, sums));
  }
  const Eigen::Index n = kernel.numParams();
  result.information = sums.gram.topLeftCorner(n, n).selfadjointView<Eigen::Lower>();

  const Eigen::MatrixXd directions = freeDirections(static_cast<int>(result.information.rows()), constraint);
  if (directions.cols() == 0) {
    result.scaled_condition = 1;
    result.inverse = Eigen::MatrixXd::Zero(result.information.rows(), result.information.rows());
    return result;
  }
  const Eigen::MatrixXd information = directions.transpose() * result.information * directions;
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return result;
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  if (solver.info() != Eigen::Success) return result;
  const Eigen::VectorXd& values = solver.eigenvalues();
  result.scaled_condition = std::max(0.0, values(0) / values(values.size() - 1));
  // Below this, the smallest eigenvalue is rounding: the Schur complement subtracts numbers of its own size.
  constexpr double kSingular = 1e-13;
  if (!(result.scaled_condition > kSingular)) return result;
  const Eigen::MatrixXd& vectors = solver.eigenvectors();
  const Eigen::MatrixXd inverse = vectors * values.cwiseInverse().asDiagonal() * vectors.transpose();
  result.inverse = directions * (scale.asDiagonal() * inverse * scale.asDiagonal()) * directions.transpose();
  return result;
}

double meanSlope(std::span<const Eigen::Vector2d> weighted_errors, HuberLoss loss) {
  double sum = 0;  // psi' along and across the error, both axes of each corner
  for (const Eigen::Vector2d& error : weighted_errors) {
    const double weight = loss.weight(error.squaredNorm());
    sum += weight + (weight < 1.0 ? 0.0 : 1.0);
  }
  return sum / (2.0 * static_cast<double>(weighted_errors.size()));
}

double coordinateVariance(std::span<const Eigen::Vector2d> weighted_errors, HuberLoss loss,
                          int num_free_params) {
  double sum_psi2 = 0;
  for (const Eigen::Vector2d& error : weighted_errors) {
    const double s = error.squaredNorm();
    const double weight = loss.weight(s);
    sum_psi2 += weight * weight * s;
  }
  const double freedom = 2.0 * static_cast<double>(weighted_errors.size()) - num_free_params;
  if (!(freedom > 0)) return std::numeric_limits<double>::infinity();
  const double slope = meanSlope(weighted_errors, loss);
  return sum_psi2 / freedom / (slope * slope);
}

std::optional<Eigen::MatrixXd> viewRobustCovariance(std::string_view model_id,
                                                    std::span<const std::vector<Observation>> views,
                                                    const BundleState& state, HuberLoss loss,
                                                    double mean_slope, const ParamConstraint& constraint) {
  const ViewKernel& kernel = viewKernel(model_id);
  const Eigen::Index n = kernel.numParams();
  const auto num_views = static_cast<double>(views.size());
  if (!(num_views > static_cast<double>(n))) return std::nullopt;
  const auto inverse = intrinsicsInformation(model_id, views, state, constraint).inverse;
  if (!inverse) return std::nullopt;
  const CornerGroups corners(views);
  PoseRows rows(6, n + 7);
  Eigen::MatrixXd pulls = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t v = 0; v < views.size(); ++v) {
    SharedSums sums(kernel.numParams());
    static_cast<void>(kernel.reduce(state.params.data(), state.camera_from_board[v], corners.view(v), loss,
                                    Unseen::kLeaveOut, rows, sums));
    const Eigen::VectorXd pull = sums.gram.row(n).head(n).transpose();
    pulls += pull * pull.transpose();
  }
  const double scale = num_views / (num_views - 1) / (mean_slope * mean_slope);
  return scale * *inverse * pulls * *inverse;
}

}  // namespace alidade
