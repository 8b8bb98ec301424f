// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/covariance.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "alidade/adjust/board/reduced.h"
#include "alidade/adjust/board/view_kernel.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {

ScaledInverse scaledInverse(const Eigen::MatrixXd& matrix, double singular) {
  ScaledInverse result;
  const Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return result;
  const Eigen::MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  const SymmetricEigen solver(scaled);
  if (!solver.isFound()) return result;
  const Eigen::VectorXd& values = solver.eigenvalues();
  result.condition = std::max(0.0, values(0) / values(values.size() - 1));
  if (!(result.condition > singular)) return result;
  const Eigen::MatrixXd& vectors = solver.eigenvectors();
  const Eigen::MatrixXd inverse = vectors * values.cwiseInverse().asDiagonal() * vectors.transpose();
  result.inverse = scale.asDiagonal() * inverse * scale.asDiagonal();
  return result;
}

ScaledInverse inverseAlong(const Eigen::MatrixXd& directions, const Eigen::MatrixXd& matrix) {
  if (directions.cols() == 0)
    return {.condition = 1, .inverse = Eigen::MatrixXd::Zero(matrix.rows(), matrix.rows())};
  ScaledInverse result = scaledInverse(directions.transpose() * matrix * directions);
  if (result.inverse) result.inverse = directions * *result.inverse * directions.transpose();
  return result;
}

IntrinsicsInformation intrinsicsInformation(const Fit& fit) {
  const FitCamera& camera = onlyCamera(fit);
  // The Schur complement of the poses in J^T W J is that of a fit without a loss.
  const ViewKernel& kernel = viewKernel(camera.model, camera.params.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kernel.numParams(), kernel.numParams());
  for (const FitView& view : fit.views) {
    if (boardOf(fit, view).isFlexible()) {
      information += reduced(fit, view, LossWeights::kLeaveOut).information;
      continue;
    }
    const auto factor = viewFactor(kernel, camera.params, cameraFromBoard(fit, view),
                                   groupsOf(cornersOnShape(fit, view)), kNoLoss, Unseen::kLeaveOut);
    information += paramsInformation(*factor);
  }
  // Below the limit, the smallest eigenvalue is rounding, because the Schur complement subtracts nearly equal
  // numbers.
  const ScaledInverse inverse =
      inverseAlong(freeDirections(kernel.numParams(), camera.constraint), information);
  return {inverse, std::move(information)};
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
                          double num_free_params) {
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

}  // namespace alidade
