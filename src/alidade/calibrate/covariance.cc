// SPDX-License-Identifier: MIT
#include "alidade/calibrate/covariance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "alidade/calibrate/normal_blocks.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

template <CameraModel M>
Eigen::MatrixXd schurComplement(std::span<const std::vector<Observation>> views, const BundleState& state) {
  constexpr int kN = kNumParams<M>;
  Eigen::Matrix<double, kN, kN> sum = Eigen::Matrix<double, kN, kN>::Zero();
  for (std::size_t v = 0; v < views.size(); ++v) {
    const detail::NormalBlocks<M> blocks(state.params.data(), state.camera_from_board[v], views[v]);
    sum += blocks.params_params -
           blocks.pose_params.transpose() * blocks.pose_pose.ldlt().solve(blocks.pose_params);
  }
  return 0.5 * (sum + sum.transpose());
}

}  // namespace

IntrinsicsInformation intrinsicsInformation(std::string_view model_id,
                                            std::span<const std::vector<Observation>> views,
                                            const BundleState& state, const ParamConstraint& constraint) {
  IntrinsicsInformation result;
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if (M::kId == model_id) result.information = schurComplement<M>(views, state);
  });
  expect(result.information.size() > 0, "the model's id is known");

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

double coordinateVariance(std::span<const Eigen::Vector2d> weighted_errors, HuberLoss loss,
                          int num_free_params) {
  double sum_psi2 = 0;
  double sum_slope = 0;  // psi' along and across the error, both axes of each corner
  for (const Eigen::Vector2d& error : weighted_errors) {
    const double s = error.squaredNorm();
    const double weight = loss.weight(s);
    sum_psi2 += weight * weight * s;
    sum_slope += weight + (weight < 1.0 ? 0.0 : 1.0);
  }
  const double num_coordinates = 2.0 * static_cast<double>(weighted_errors.size());
  const double freedom = num_coordinates - num_free_params;
  if (!(freedom > 0)) return std::numeric_limits<double>::infinity();
  const double mean_slope = sum_slope / num_coordinates;
  return sum_psi2 / freedom / (mean_slope * mean_slope);
}

}  // namespace alidade
