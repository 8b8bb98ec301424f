// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/camera/radtan.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "support/fit_set.h"
#include "support/image_sizes.h"
#include "support/reprojection.h"

namespace alidade {
namespace {

// At the truth, corners of all kinds of weights.
Fit makeFit(int num_views) {
  const std::vector<double> truth = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
  Fit fit =
      fitAt(simulateSet(AnyCamera::make("radtan", truth), kQuadVga, num_views, 0.1, 1), "radtan", truth);
  Random random(2);
  for (FitView& view : fit.views) {
    for (Observation& corner : view.corners) corner.weight = random.uniform(0.05, 5.0);
  }
  return fit;
}

TEST(Leverages, AreTheDiagonalOfTheHatMatrix) {
  const Fit fit = makeFit(4);
  const auto num_rows = 2 * static_cast<Eigen::Index>(numCorners(fit));
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(num_rows, 9 + 6 * 4);
  Eigen::Index row = 0;
  Reprojection<Radtan> corner;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    const SE3 pose = cameraFromBoard(fit, fit.views[v]);
    for (const Observation& observation : fit.views[v].corners) {
      ASSERT_TRUE(reproject<Radtan>(fit.cameras.front().params.data(), pose.rotation.matrix(),
                                    pose.translation, observation.p_board, corner));
      const double root = std::sqrt(observation.weight);
      J.block<2, 9>(row, 0) = root * corner.J_px_params;
      J.block<2, 6>(row, 9 + 6 * static_cast<Eigen::Index>(v)) = root * corner.J_px_pose;
      row += 2;
    }
  }
  const Eigen::VectorXd scale = J.colwise().norm().cwiseInverse();
  J = J * scale.asDiagonal();
  const Eigen::MatrixXd Q =
      Eigen::HouseholderQR<Eigen::MatrixXd>(J).householderQ() * Eigen::MatrixXd::Identity(num_rows, J.cols());
  const auto all = leverages(fit);
  row = 0;
  for (const auto& view : all) {
    for (const double leverage : view) {
      EXPECT_NEAR(leverage, Q.middleRows<2>(row).squaredNorm(), 1e-7);
      row += 2;
    }
  }
  EXPECT_EQ(row, num_rows);
}

TEST(Leverages, AddUpToTheFreeParameters) {
  const Fit fit = makeFit(12);
  double sum = 0;
  for (const auto& view : leverages(fit)) {
    for (const double leverage : view) sum += leverage;
  }
  EXPECT_NEAR(sum, 9 + 12 * 6, 1e-6);
}

}  // namespace
}  // namespace alidade
