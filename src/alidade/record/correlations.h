// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "alidade/core/error.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {

/// A lower triangle, row by row, as correlations and standard deviations, because the units of the parameters
/// span ten orders of magnitude.
struct Correlations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd std;

  Correlations(std::span<const double> triangle, Eigen::Index n) : matrix(n, n) {
    expect(static_cast<Eigen::Index>(triangle.size()) == n * (n + 1) / 2, "a whole lower triangle");
    std::size_t k = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) matrix(i, j) = matrix(j, i) = triangle[k++];
    }
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
