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

}  // namespace alidade
