// SPDX-License-Identifier: MIT
#include "alidade/calibrate/leverage.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "alidade/calibrate/start.h"
#include "support/reprojection.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{.width = 1280, .height = 960};

struct Fit {
  std::vector<std::vector<Observation>> observations;
  BundleState state;
};

// At the truth, corners of all kinds of weights.
Fit makeFit(int num_views) {
  const std::vector<double> truth = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
  const SimulatedSet set = simulateSet(AnyCamera::make("radtan", truth), kSize, num_views, 0.1, 1);
  Fit fit{.observations = observationsOf(set.board, set.views),
          .state = {.params = truth, .camera_from_board = set.poses}};
  Random random(2);
  for (auto& view : fit.observations) {
    for (Observation& observation : view) observation.weight = random.uniform(0.05, 5.0);
  }
  return fit;
}

TEST(Leverages, AreTheDiagonalOfTheHatMatrix) {
  const Fit fit = makeFit(4);
  Eigen::Index num_rows = 0;
  for (const auto& view : fit.observations) num_rows += 2 * static_cast<Eigen::Index>(view.size());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(num_rows, 9 + 6 * 4);
  Eigen::Index row = 0;
  Reprojection<Radtan> corner;
  for (std::size_t v = 0; v < fit.observations.size(); ++v) {
    const SE3& pose = fit.state.camera_from_board[v];
    for (const Observation& observation : fit.observations[v]) {
      ASSERT_TRUE(reproject<Radtan>(fit.state.params.data(), pose.rotation.matrix(), pose.translation,
                                    observation.p_board, corner));
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
  const auto all = leverages("radtan", fit.observations, fit.state);
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
  for (const auto& view : leverages("radtan", fit.observations, fit.state)) {
    for (const double leverage : view) sum += leverage;
  }
  EXPECT_NEAR(sum, 9 + 12 * 6, 1e-6);
}

}  // namespace
}  // namespace alidade
