// SPDX-License-Identifier: MIT
#include "alidade/handeye/joint_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Cholesky>

#include "alidade/core/cancel.h"
#include "alidade/simulate/observe.h"
#include "robot_scenes.h"

namespace alidade {
namespace {

constexpr RobotNoise kUsualRobot{.rotation_rad = 2e-3, .translation_m = 1.5e-3};

// A fit of a set's views that starts near the truth.
RobotFit fitOf(const RobotSet& set) {
  RobotFit robot{.fit = {},
                 .camera_on = set.scene.camera_on,
                 .mount_from_camera = set.mount_from_camera * SE3::exp(SE3::Tangent::Constant(0.005)),
                 .world_from_boards = set.world_from_boards,
                 .noise = {.rotation_rad = 1e-3, .translation_m = 1e-3},
                 .corner_sigma_px = 0.2};
  Fit& fit = robot.fit;
  fit.cameras = {{.model = "radtan", .size = set.scene.size, .params = fitParams(set.scene.camera)}};
  for (std::size_t b = 0; b < set.world_from_boards.size(); ++b) fit.boards.push_back({set.scene.board});
  for (std::size_t i = 0; i < set.views.size(); ++i) {
    const std::size_t board = i % set.world_from_boards.size();
    addView(fit, i, observationsOf(set.scene.board, set.views[i]),
            cameraFromBoard(set, i, set.world_from_boards[board]), board);
    robot.frames.push_back({.base_from_gripper = set.robot.poses[i].base_from_gripper, .views = {i}});
  }
  return robot;
}

// Every other image shows a second board, 8 cm beside the first.
RobotSet withSecondBoard(RobotSet set) {
  set.world_from_boards.push_back(set.world_from_boards[0] * SE3{SO3::exp({0.1, 0.2, 0}), {0.08, 0, 0.01}});
  Random noise(77);
  for (std::size_t i = 1; i < set.views.size(); i += 2) {
    View& view = set.views[i];
    view = exactView(set.scene.camera, set.scene.size, set.scene.board,
                     cameraFromBoard(set, i, set.world_from_boards[1]), view.image);
    if (set.scene.corner_noise_px > 0) addCornerNoise(view, set.scene.corner_noise_px, noise);
  }
  return set;
}

// By how much mount and boards are off, one tangent below the other.
Eigen::VectorXd errorsOf(const RobotFit& fit, const RobotSet& set) {
  Eigen::VectorXd errors(6 * (1 + std::ssize(set.world_from_boards)));
  errors.head<6>() = differenceOf(set.mount_from_camera, fit.mount_from_camera);
  for (std::size_t b = 0; b < set.world_from_boards.size(); ++b)
    errors.segment<6>(6 * (1 + static_cast<Eigen::Index>(b))) =
        differenceOf(set.world_from_boards[b], fit.world_from_boards.at(b));
  return errors;
}

TEST(JointFit, FindsTheTruthOfAnExactRobotAndExactCorners) {
  int num_sets = 0;
  for (const CameraOn camera_on : kBothPlaces) {
    for (const bool has_two : {false, true}) {
      for (std::uint64_t seed = 0; seed < 3; ++seed, ++num_sets) {
        RobotSet set = simulateRobot(robotScene(camera_on), seed);
        if (has_two) set = withSecondBoard(std::move(set));
        const RobotFit fit = solved(fitOf(set), nullptr);
        EXPECT_TRUE(fit.is_converged);
        EXPECT_LT(errorsOf(fit, set).norm(), 1e-7);
        EXPECT_LT(fit.noise.rotation_rad, 1e-7);
        EXPECT_LT(fit.noise.translation_m, 1e-7);
      }
    }
  }
  EXPECT_EQ(num_sets, 2 * 2 * 3);
}

TEST(JointFit, StatesTheScatterOfItsResult) {
  struct Case {
    CameraOn camera_on;
    bool has_two;
    RobotNoise robot;
    double corners_px;
  };
  const std::vector<Case> cases = {{CameraOn::kHand, false, kUsualRobot, 0.1},
                                   {CameraOn::kBase, false, kUsualRobot, 0.1},
                                   {CameraOn::kHand, false, kUsualRobot, 0},
                                   {CameraOn::kHand, true, {2e-4, 1e-4}, 0.3}};
  int num_sets = 0;
  for (const auto& [camera_on, has_two, robot, corners_px] : cases) {
    constexpr int kNumSets = 60;
    double squares = 0;
    double count = 0;
    for (std::uint64_t seed = 0; seed < kNumSets; ++seed, ++num_sets) {
      RobotSet set = simulateRobot(robotScene(camera_on, robot, corners_px, 20), seed);
      if (has_two) set = withSecondBoard(std::move(set));
      const RobotFit fit = solved(fitOf(set), nullptr);
      EXPECT_TRUE(fit.is_converged) << seed;
      const Eigen::VectorXd errors = errorsOf(fit, set);
      const Eigen::MatrixXd covariance = fit.covariance.bottomRightCorner(errors.size(), errors.size());
      squares += errors.dot(covariance.llt().solve(errors));
      count += static_cast<double>(errors.size());
    }
    EXPECT_NEAR(std::sqrt(squares / count), 1, 0.12);
  }
  EXPECT_EQ(num_sets, 4 * 60);
}

TEST(JointFit, FindsTheNoiseThatTheCornersDetermine) {
  int num_sets = 0;
  for (const CameraOn camera_on : kBothPlaces) {
    for (const double factor : {1.0, 3.0}) {
      double rotation = 0;
      double translation = 0;
      constexpr int kNumSets = 15;
      for (std::uint64_t seed = 0; seed < kNumSets; ++seed, ++num_sets) {
        const RobotNoise robot{factor * kUsualRobot.rotation_rad, factor * kUsualRobot.translation_m};
        const RobotFit fit = solved(fitOf(simulateRobot(robotScene(camera_on, robot, 0.1), seed)), nullptr);
        EXPECT_NEAR(fit.noise.rotation_rad / robot.rotation_rad, 1, 0.5) << seed;
        EXPECT_NEAR(fit.noise.translation_m / robot.translation_m, 1, 0.5) << seed;
        EXPECT_NEAR(fit.corner_sigma_px, 0.1, 0.015) << seed;
        rotation += std::pow(fit.noise.rotation_rad / robot.rotation_rad, 2) / kNumSets;
        translation += std::pow(fit.noise.translation_m / robot.translation_m, 2) / kNumSets;
      }
      // Variances are without bias.
      EXPECT_NEAR(rotation, 1, 0.2);
      EXPECT_NEAR(translation, 1, 0.2);
    }
  }
  EXPECT_EQ(num_sets, 2 * 2 * 15);
}

TEST(JointFit, DoesNotDependOnTheOrderOfTheFrames) {
  for (const CameraOn camera_on : kBothPlaces) {
    const RobotSet set = withSecondBoard(simulateRobot(robotScene(camera_on, kUsualRobot, 0.1), 3));
    const RobotFit start = fitOf(set);
    RobotFit other = start;
    std::ranges::reverse(other.frames);
    std::swap(other.frames[2], other.frames[9]);
    const RobotFit a = solved(start, nullptr);
    const RobotFit b = solved(other, nullptr);
    EXPECT_LT((errorsOf(a, set) - errorsOf(b, set)).norm(), 1e-8);
    EXPECT_NEAR(a.noise.rotation_rad / b.noise.rotation_rad, 1, 1e-6);
    EXPECT_NEAR(a.noise.translation_m / b.noise.translation_m, 1, 1e-6);
    EXPECT_LT((a.covariance - b.covariance).norm(), 1e-5 * a.covariance.norm());
  }
}

TEST(JointFit, KnowsWhatLessNoiseOrAKnownLensWouldGive) {
  const RobotFit fit =
      solved(fitOf(simulateRobot(robotScene(CameraOn::kHand, kUsualRobot, 0.1), 3)), nullptr);
  const Eigen::Index n = fit.numParams();
  const auto traceWith = [&](const RobotNoiseShares& shares) {
    return covarianceWith(fit, shares).block<3, 3>(n, n).trace();
  };
  const double all = traceWith({});
  EXPECT_NEAR(all / fit.covariance.block(n, n, 3, 3).trace(), 1, 1e-9);
  for (const RobotNoiseShares& shares :
       {RobotNoiseShares{.corners = 0.1}, RobotNoiseShares{.translation = 0.1},
        RobotNoiseShares{.rotation = 0.1}, RobotNoiseShares{.is_lens_known = true}})
    EXPECT_LT(traceWith(shares), all);
  const RobotNoiseShares tenth{0.1, 0.1, 0.1};
  EXPECT_NEAR(traceWith(tenth) / all, 0.01, 1e-6);
  EXPECT_EQ(covarianceWith(fit, {.is_lens_known = true}).topLeftCorner(n, n).norm(), 0);
}

TEST(JointFit, StopsWhenAsked) {
  const CancelFlag cancel{true};
  EXPECT_THROW((void)solved(fitOf(simulateRobot(robotScene(CameraOn::kHand), 1)), &cancel), Cancelled);
}

}  // namespace
}  // namespace alidade
