// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace alidade {

/// Eigenvalues and eigenvectors of a symmetric matrix, of which the lower triangle is read. Eigen's solver
/// takes seconds to compile in every source that names it; it is compiled once here.
class SymmetricEigen {
 public:
  explicit SymmetricEigen(const Eigen::MatrixXd& matrix);
  /// Solves matrix v = value metric v, for a positive definite metric: eigenvectors of length 1 in it.
  SymmetricEigen(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& metric);

  [[nodiscard]] const Eigen::VectorXd& eigenvalues() const { return values_; }  ///< ascending
  [[nodiscard]] const Eigen::MatrixXd& eigenvectors() const {
    return vectors_;
  }  ///< unit length, a column each
  /// False where the matrix has elements that are not finite, or the iteration did not end.
  [[nodiscard]] bool isFound() const { return is_found_; }

 private:
  Eigen::VectorXd values_;
  Eigen::MatrixXd vectors_;
  bool is_found_ = false;
};

}  // namespace alidade
