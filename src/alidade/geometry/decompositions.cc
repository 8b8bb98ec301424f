// SPDX-License-Identifier: MIT
#include "alidade/geometry/decompositions.h"

#include <Eigen/QR>
#include <Eigen/SVD>

namespace alidade {

Svd3 svdOf(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {.U = svd.matrixU(), .values = svd.singularValues(), .V = svd.matrixV()};
}

Eigen::VectorXd leastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return leastSquares(A, Eigen::MatrixXd(b));  // compiles faster than a decomposition for vectors
}

Eigen::MatrixXd leastSquares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return A.completeOrthogonalDecomposition().solve(B);
}

Eigen::Quaterniond shortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d start = from.normalized();
  const Eigen::Vector3d halfway = start + to.normalized();
  const double length = halfway.norm();
  constexpr double kOpposite = 1e-6;  // where what is left of the sum is rounding; any axis across does
  const Eigen::Vector3d end = length < kOpposite ? start.unitOrthogonal() : Eigen::Vector3d(halfway / length);
  const Eigen::Vector3d axis = start.cross(end);
  return {start.dot(end), axis.x(), axis.y(), axis.z()};
}

}  // namespace alidade
