// SPDX-License-Identifier: MIT
// Eigen's decompositions behind plain functions: each takes seconds to compile in every source that names it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace alidade {

/// U diag(values) V^T of a 3x3 matrix, the values in falling order.
struct Svd3 {
  Eigen::Matrix3d U;
  Eigen::Vector3d values;
  Eigen::Matrix3d V;
};

[[nodiscard]] Svd3 svdOf(const Eigen::Matrix3d& matrix);

/// The X of least norm for which A X is nearest to B.
[[nodiscard]] Eigen::VectorXd leastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::MatrixXd leastSquares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// The shortest rotation that takes the direction of one vector to that of another.
[[nodiscard]] Eigen::Quaterniond shortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace alidade
