// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/geometry/symmetric_eigen.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// A lower triangle, row by row, as correlations and standard deviations, because the units of the parameters
/// span ten orders of magnitude.
struct Correlations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd std;

  Correlations(const std::vector<double>& triangle, Eigen::Index n) : matrix(fullMatrix(triangle, n).view()) {
    std = matrix.diagonal().cwiseSqrt();
    for (Eigen::Index i = 0; i < n; ++i) {
      // A parameter that was held has neither variance nor covariance.
      const double scale = matrix.row(i).isZero(0) ? 1 : 1 / std(i);
      matrix.row(i) *= scale;
      matrix.col(i) *= scale;
    }
  }

  // One focal length for both axes makes it singular; rounding may then leave an eigenvalue below zero.
  [[nodiscard]] bool isSemidefinite() const {
    constexpr double kRounding = 1e-10;
    if (!matrix.allFinite()) return false;
    const SymmetricEigen solver(matrix);
    return solver.eigenvalues().minCoeff() >= -kRounding * static_cast<double>(matrix.rows());
  }
};

}  // namespace alidade
