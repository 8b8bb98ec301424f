// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace alidade {

/// A matrix of any size, as it stands in public structs.
///
/// Its memory is a std::vector's: Eigen's own allocator depends on the compiler's flags (-mavx2, sanitizers),
/// and a matrix that the library makes is destroyed by a program that may be compiled with others. To
/// calculate, take view().
class DenseMatrix {
 public:
  using View = Eigen::Map<const Eigen::MatrixXd>;

  /// 0 x 0.
  DenseMatrix() = default;
  /// Of any expression of Eigen's; implicit, so that such a member takes what was calculated.
  template <class Derived>
  DenseMatrix(const Eigen::MatrixBase<Derived>& matrix)  // NOLINT(google-explicit-constructor)
      : rows_(matrix.rows()), cols_(matrix.cols()), values_(static_cast<std::size_t>(rows_ * cols_)) {
    Eigen::Map<Eigen::MatrixXd>(values_.data(), rows_, cols_) = matrix;
  }

  [[nodiscard]] Eigen::Index rows() const { return rows_; }
  [[nodiscard]] Eigen::Index cols() const { return cols_; }
  [[nodiscard]] double operator()(Eigen::Index row, Eigen::Index col) const { return view()(row, col); }
  /// Valid as long as this matrix lives and is not assigned to.
  [[nodiscard]] View view() const { return {values_.data(), rows_, cols_}; }
  /// A copy, for functions that take one of Eigen's.
  operator Eigen::MatrixXd() const { return view(); }  // NOLINT(google-explicit-constructor)

  friend bool operator==(const DenseMatrix&, const DenseMatrix&) = default;

 private:
  Eigen::Index rows_ = 0;
  Eigen::Index cols_ = 0;
  std::vector<double> values_;  // column by column
};

}  // namespace alidade
