// SPDX-License-Identifier: MIT
#include "alidade/geometry/dense_matrix.h"

#include <gtest/gtest.h>

#include <optional>

namespace alidade {
namespace {

Eigen::MatrixXd numbered(Eigen::Index rows, Eigen::Index cols) {
  return Eigen::VectorXd::LinSpaced(rows * cols, 0, static_cast<double>(rows * cols - 1))
      .reshaped(rows, cols);
}

TEST(DenseMatrixTest, HoldsTheValuesOfAnExpression) {
  const Eigen::MatrixXd given = numbered(2, 3);
  const DenseMatrix matrix = 2 * given.transpose();
  ASSERT_EQ(matrix.rows(), 3);
  ASSERT_EQ(matrix.cols(), 2);
  EXPECT_EQ(matrix(2, 1), 2 * given(1, 2));
  EXPECT_EQ(matrix.view(), 2 * given.transpose());
}

TEST(DenseMatrixTest, IsNotConfusedByAnExpressionOfItself) {
  DenseMatrix matrix = numbered(2, 2);
  matrix = matrix.view().transpose() * matrix.view();
  const Eigen::MatrixXd given = numbered(2, 2);
  EXPECT_EQ(matrix.view(), given.transpose() * given);
}

TEST(DenseMatrixTest, GoesToAndFromEigenUnasked) {
  const std::optional<DenseMatrix> matrix = numbered(3, 3);
  const Eigen::MatrixXd copy = *matrix;
  EXPECT_EQ(copy, numbered(3, 3));
  EXPECT_EQ(matrix, numbered(3, 3));
  EXPECT_NE(*matrix, DenseMatrix(numbered(9, 1)));
}

TEST(DenseMatrixTest, IsEmptyUnlessToldOtherwise) {
  const DenseMatrix matrix;
  EXPECT_EQ(matrix.rows(), 0);
  EXPECT_EQ(matrix.view().size(), 0);
}

}  // namespace
}  // namespace alidade
