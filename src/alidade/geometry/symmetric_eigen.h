// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace alidade {

/// Eigenvalues and eigenvectors of a symmetric matrix; only the lower triangle is read. Eigen's solver takes
/// seconds to compile in every source that names it, so it is compiled once here.
class SymmetricEigen {
 public:
  explicit SymmetricEigen(const Eigen::MatrixXd& matrix);
  /// Solves matrix v = value metric v for a positive definite metric; eigenvectors have length 1 in the
  /// metric.
  SymmetricEigen(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& metric);

  [[nodiscard]] const Eigen::VectorXd& eigenvalues() const { return values_; }  ///< ascending
  [[nodiscard]] const Eigen::MatrixXd& eigenvectors() const {
    return vectors_;
  }  ///< unit length, one column each
  /// False if the matrix has elements that are not finite, or the iteration did not converge.
  [[nodiscard]] bool isFound() const { return is_found_; }

 private:
  Eigen::VectorXd values_;
  Eigen::MatrixXd vectors_;
  bool is_found_ = false;
};

}  // namespace alidade
