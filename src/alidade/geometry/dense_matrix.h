// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace alidade {

/// An unaligned matrix for public structs: Eigen's alignment of 32 bytes depends on compiler flags.
using UnalignedMatrix2d = Eigen::Matrix<double, 2, 2, Eigen::DontAlign>;

/// A matrix of any size, for public structs.
///
/// It stores its elements in a std::vector, because Eigen's allocator depends on compiler flags (-mavx2,
/// sanitizers). The program that destroys a matrix may be compiled with different flags from the library that
/// created it. Use view() to calculate.
class DenseMatrix {
 public:
  using View = Eigen::Map<const Eigen::MatrixXd>;

  /// 0 x 0.
  DenseMatrix() = default;
  /// From any Eigen expression; implicit, so that results can be assigned to members directly.
  template <class Derived>
  DenseMatrix(const Eigen::MatrixBase<Derived>& matrix)  // NOLINT(google-explicit-constructor)
      : rows_(matrix.rows()), cols_(matrix.cols()), values_(static_cast<std::size_t>(rows_ * cols_)) {
    Eigen::Map<Eigen::MatrixXd>(values_.data(), rows_, cols_) = matrix;
  }

  [[nodiscard]] Eigen::Index rows() const { return rows_; }
  [[nodiscard]] Eigen::Index cols() const { return cols_; }
  [[nodiscard]] double operator()(Eigen::Index row, Eigen::Index col) const { return view()(row, col); }
  /// Valid until this matrix is destroyed or assigned to.
  [[nodiscard]] View view() const { return {values_.data(), rows_, cols_}; }
  /// A copy, for functions that take an Eigen matrix.
  operator Eigen::MatrixXd() const { return view(); }  // NOLINT(google-explicit-constructor)

  friend bool operator==(const DenseMatrix&, const DenseMatrix&) = default;

 private:
  Eigen::Index rows_ = 0;
  Eigen::Index cols_ = 0;
  std::vector<double> values_;  // column by column
};

}  // namespace alidade
