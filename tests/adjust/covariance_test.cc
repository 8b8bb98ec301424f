// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/covariance.h"

#include <gtest/gtest.h>

#include <ceres/ceres.h>

#include <cmath>
#include <numbers>

#include "alidade/adjust/board/solve.h"
#include "alidade/camera/radtan.h"
#include "support/corner_cost.h"
#include "support/fit_set.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

TEST(IntrinsicsInformation, InverseEqualsCeresCovariance) {
  const std::vector<double> truth = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
  const SimulatedSet set = simulateSet(AnyCamera::make("radtan", truth), kQuadVga, 10, 0.1, 1);
  Fit fit = fitAt(set, "radtan", truth);
  Random random(2);
  for (FitView& view : fit.views) {
    for (Observation& corner : view.corners) corner.weight = random.uniform(0.1, 3.0);
  }
  fit = solve(std::move(fit));
  ASSERT_EQ(fit.summary.termination, Termination::kConverged);
  std::vector<double>& params = fit.cameras.front().params;

  ceres::Problem problem;
  std::vector<PoseBlock> poses;
  for (const FitView& view : fit.views) poses.push_back(toBlock(cameraFromBoard(fit, view)));
  addCorners<Radtan>(problem, cornersOf(fit), nullptr, params, poses);
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance covariance(options);
  const std::vector<std::pair<const double*, const double*>> blocks = {{params.data(), params.data()}};
  ASSERT_TRUE(covariance.Compute(blocks, &problem));
  Eigen::Matrix<double, 9, 9, Eigen::RowMajor> expected;
  ASSERT_TRUE(covariance.GetCovarianceBlock(params.data(), params.data(), expected.data()));

  const IntrinsicsInformation information = intrinsicsInformation(fit);
  ASSERT_TRUE(information.inverse);
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 9; ++j) {
      const double scale = std::sqrt(expected(i, i) * expected(j, j));
      EXPECT_NEAR((*information.inverse)(i, j), expected(i, j), 1e-6 * scale) << i << "," << j;
    }
  }
}

TEST(IntrinsicsInformation, FrontoParallelViewsAreSingular) {
  const std::vector<double> truth = {1003, 1003, 639.5, 479.5};
  const AnyCamera camera = AnyCamera::make("pinhole", truth);
  const Checkerboard board{.columns = 9, .rows = 6, .square_m = 0.025};
  Fit fit = emptyFit("pinhole", kQuadVga, truth, board, kNoLoss);
  for (std::size_t i = 0; i < 6; ++i) {
    SE3 pose;
    pose.translation = {-0.1 + 0.02 * static_cast<double>(i), -0.05, 0.4 + 0.05 * static_cast<double>(i)};
    addView(fit, i, observationsOf(board, exactView(camera, kQuadVga, board, pose, std::to_string(i))), pose);
  }
  const auto information = intrinsicsInformation(fit);
  EXPECT_FALSE(information.inverse);
  EXPECT_LT(information.condition, 1e-10);
}

TEST(CoordinateVariance, CountsCoordinatesAndParameters) {
  // 8 corners off by (3, 4): 8 * 25 over 16 coordinates less 6 parameters.
  const std::vector<Eigen::Vector2d> errors(8, Eigen::Vector2d(3, 4));
  EXPECT_DOUBLE_EQ(coordinateVariance(errors, kNoLoss, 6), 20.0);
  EXPECT_TRUE(std::isinf(coordinateVariance(errors, kNoLoss, 16)));
}

TEST(CoordinateVariance, HuberOnCleanNoiseIsUnbiased) {
  Random random(1);
  std::vector<Eigen::Vector2d> errors;
  for (int i = 0; i < 200000; ++i) errors.emplace_back(0.3 * random.normal(), 0.3 * random.normal());
  // At 3 sigma the estimate's own variance is that of least squares to 1 %; five standard errors of the mean
  // besides.
  EXPECT_NEAR(coordinateVariance(errors, {.threshold_px = 0.9}, 0), 0.09, 0.09 * 0.015);
}

TEST(CoordinateVariance, CorrectsForTheShareOfCornersBeyondTheThreshold) {
  // At a threshold of one sigma, Rayleigh's distribution of the error's length gives, per coordinate, a mean
  // psi^2 of (1 - e^-1/2) sigma^2 and a mean slope of (1 - e^-1/2) + sqrt(pi / 2) erfc(1 / sqrt 2) / 2.
  // The estimate over this many corners scatters by 0.3 %; without the correction it would be a third.
  Random random(2);
  std::vector<Eigen::Vector2d> errors;
  for (int i = 0; i < 400000; ++i) errors.emplace_back(0.3 * random.normal(), 0.3 * random.normal());
  const double inside = 1 - std::exp(-0.5);
  const double slope = inside + 0.5 * std::sqrt(std::numbers::pi / 2) * std::erfc(1 / std::sqrt(2.0));
  EXPECT_NEAR(coordinateVariance(errors, {.threshold_px = 0.3}, 0), 0.09 * inside / (slope * slope),
              0.1 * 0.01);
}

}  // namespace
}  // namespace alidade
