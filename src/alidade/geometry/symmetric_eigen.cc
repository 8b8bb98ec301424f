// SPDX-License-Identifier: MIT
#include "alidade/geometry/symmetric_eigen.h"

#include <Eigen/Eigenvalues>

namespace alidade {

SymmetricEigen::SymmetricEigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  values_ = solver.eigenvalues();
  vectors_ = solver.eigenvectors();
  is_found_ = solver.info() == Eigen::Success;
}

SymmetricEigen::SymmetricEigen(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& metric) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix, metric);
  values_ = solver.eigenvalues();
  vectors_ = solver.eigenvectors();
  is_found_ = solver.info() == Eigen::Success;
}

}  // namespace alidade
