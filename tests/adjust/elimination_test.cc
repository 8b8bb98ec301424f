// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/view_equations.h"

#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/Core>

#include "alidade/core/random.h"

namespace alidade {
namespace {

constexpr std::size_t kSize = 12;
constexpr int kLast = kSize - 1;
using Gram = Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>;

// R^T R with the rows that are left when first the columns before kSplit are eliminated and then the others.
template <std::size_t kSplit>
Gram factorizedAndMultiplied(const Gram& gram) {
  detail::EliminationEquations equations(kSize);
  std::array<double, kSize> diagonal;
  for (std::size_t i = 0; i < kSize; ++i) {
    for (std::size_t j = 0; j < kSize; ++j)
      equations.at(i, j) = gram(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    diagonal[i] = equations.at(i, i);
  }
  Gram R = Gram::Zero();
  equations.eliminate(0, kSplit, diagonal.data(), R.data());
  equations.mirror(kSplit, kSize);  // the Schur complement is left in the upper triangle
  equations.eliminate(kSplit, kSize - 1, diagonal.data(), R.row(kSplit).data());
  R(kLast, kLast) = std::sqrt(std::max(equations.at(kLast, kLast), 0.0));
  return R.transpose() * R;
}

// Columns of very different scales that depend on each other, as those of one flat view do: pivots there are
// rounding, and must neither blow up nor cost the gradient its digits.
template <std::size_t kSplit>
void expectGradientKept() {
  Random random(3);
  int num_checked = 0;
  for (int set = 0; set < 2000; ++set) {
    Eigen::Matrix<double, 60, kSize> J;
    for (int i = 0; i < J.rows(); ++i) {
      for (int j = 0; j < J.cols(); ++j) J(i, j) = random.normal();
    }
    // All but four columns and the last are combinations of the four.
    for (int j = 4; j < kLast; ++j) {
      J.col(j).setZero();
      for (int k = 0; k < 4; ++k) J.col(j) += random.normal() * J.col(k);
    }
    for (int j = 0; j < kLast; ++j) J.col(j) *= std::pow(10.0, random.uniform(-4, 4));
    const Gram before = J.transpose() * J;
    const Gram again = factorizedAndMultiplied<kSplit>(before);
    ASSERT_TRUE(again.allFinite()) << "set " << set;
    for (int j = 0; j < kLast; ++j) {
      const double scale = std::sqrt(before(j, j) * before(kLast, kLast));
      ASSERT_NEAR(again(j, kLast), before(j, kLast), 1e-6 * scale) << "set " << set;
      ASSERT_NEAR(again(j, j), before(j, j), 1e-6 * before(j, j)) << "set " << set;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 2000 * kLast);
}

TEST(Elimination, KeepsTheGradientWherePivotsAreRounding) {
  expectGradientKept<kLast>();
}

TEST(Elimination, KeepsTheGradientInTwoParts) {
  expectGradientKept<6>();
  expectGradientKept<3>();
}

TEST(Elimination, GivesBackEliminationEquationsOfFullRank) {
  Random random(4);
  int num_checked = 0;
  for (int set = 0; set < 200; ++set) {
    Eigen::Matrix<double, 30, kSize> J;
    for (int i = 0; i < J.rows(); ++i) {
      for (int j = 0; j < J.cols(); ++j) J(i, j) = random.normal();
    }
    const Gram before = J.transpose() * J;
    const Gram again = factorizedAndMultiplied<6>(before);
    ASSERT_LE((again - before).norm(), 1e-13 * before.norm());
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 200);
}

}  // namespace
}  // namespace alidade
