// SPDX-License-Identifier: MIT
#include "alidade/adjust/scaled_inverse.h"

#include <algorithm>

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

}  // namespace alidade
