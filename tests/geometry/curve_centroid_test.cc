// SPDX-License-Identifier: MIT
#include "alidade/geometry/curve_centroid.h"

#include <gtest/gtest.h>

namespace alidade {
namespace {

using Points = Eigen::Matrix<double, 2, 12>;

// A disc seen by a wide lens: a homography, and a polynomial of the distance from the image's centre.
template <int kPoints>
Eigen::Matrix<double, 2, kPoints> seenDisc(double radius) {
  Eigen::Matrix<double, 2, kPoints> points = radius * unitCircle<kPoints>();
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector2d p = points.col(i);
    const Eigen::Vector2d q =
        Eigen::Vector2d(0.5 + p.x() + 0.2 * p.y(), -0.3 + 0.9 * p.y()) / (1 + 0.4 * p.x() - 0.5 * p.y());
    points.col(i) = 400 * (1 - 0.2 * q.squaredNorm()) * q + Eigen::Vector2d(700, 500);
  }
  return points;
}

TEST(CurveCentroid, IsThatOfAnEllipse) {
  Points points = unitCircle<12>();
  const Eigen::Matrix2d stretch{{30, 10}, {-5, 20}};
  points = (stretch * points).colwise() + Eigen::Vector2d(1000, -3);
  EXPECT_LT((centroidWithin(points).at - Eigen::Vector2d(1000, -3)).norm(), 1e-11);
  EXPECT_LT((centroidWithin(Points(points.rowwise().reverse())).at - Eigen::Vector2d(1000, -3)).norm(),
            1e-11);
}

TEST(CurveCentroid, ConvergesExponentially) {
  const Eigen::Vector2d truth = centroidWithin(seenDisc<64>(0.1)).at;
  EXPECT_LT((centroidWithin(seenDisc<32>(0.1)).at - truth).norm(), 1e-10);
  EXPECT_LT((centroidWithin(seenDisc<12>(0.1)).at - truth).norm(), 1e-7);
  // The middle of the disc is seen elsewhere.
  EXPECT_GT((seenDisc<8>(0).col(0) - truth).norm(), 0.3);
}

TEST(CurveCentroid, HasTheDerivativesOfItsFormula) {
  const Points points = seenDisc<12>(0.2);
  const auto centroid = centroidWithin(points);
  constexpr double kStep = 1e-4;
  int num_checked = 0;
  for (int i = 0; i < 24; ++i) {
    Points plus = points;
    Points minus = points;
    plus(i) += kStep;
    minus(i) -= kStep;
    const Eigen::Vector2d slope = (centroidWithin(plus).at - centroidWithin(minus).at) / (2 * kStep);
    EXPECT_NEAR(centroid.J_x_points(i), slope.x(), 1e-8);
    EXPECT_NEAR(centroid.J_y_points(i), slope.y(), 1e-8);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 24);
}

}  // namespace
}  // namespace alidade
