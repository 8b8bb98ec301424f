// SPDX-License-Identifier: MIT
#include "alidade/simulate/robot.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/simulate/observe.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

RobotScene sceneOf(CameraOn camera_on) {
  return {.camera =
              AnyCamera::make("radtan", std::vector<double>{500, 501, 322, 238, -0.2, 0.05, 1e-3, -5e-4, 0}),
          .size = kVga,
          .board = Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025},
          .camera_on = camera_on};
}

constexpr std::array kBothPlaces = {CameraOn::kHand, CameraOn::kBase};

SE3 cameraFromBoard(const RobotSet& set, const SE3& base_from_gripper) {
  const bool is_on_hand = set.scene.camera_on == CameraOn::kHand;
  return set.mount_from_camera.inverse() * (is_on_hand ? base_from_gripper.inverse() : base_from_gripper) *
         set.world_from_boards.at(0);
}

std::vector<SE3> stated(const std::vector<RobotPose>& poses) {
  std::vector<SE3> stated;
  for (const RobotPose& pose : poses) stated.push_back(pose.base_from_gripper);
  return stated;
}

// The largest entry of the difference of matrices.
double difference(const SE3& a, const SE3& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}
double difference(const std::vector<SE3>& a, const std::vector<SE3>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, difference(a[i], b[i]));
  return largest;
}

TEST(Robot, ClosesTheChainWithoutNoise) {
  int num_corners = 0;
  for (const CameraOn camera_on : kBothPlaces) {
    const RobotSet set = simulateRobot(sceneOf(camera_on), 3);
    ASSERT_EQ(set.views.size(), 15U);
    ASSERT_EQ(set.robot.poses.size(), 15U);
    EXPECT_EQ(set.views[7].image, "007.png");
    EXPECT_LT(difference(stated(set.robot.poses), set.base_from_gripper), 1e-15);
    for (std::size_t i = 0; i < set.views.size(); ++i) {
      EXPECT_EQ(set.robot.poses[i].image, set.views[i].image);
      const SE3 pose = cameraFromBoard(set, set.robot.poses[i].base_from_gripper);
      const View seen = exactView(set.scene.camera, kVga, set.scene.board, pose, "");
      ASSERT_EQ(seen.corners.size(), set.views[i].corners.size());
      for (std::size_t k = 0; k < seen.corners.size(); ++k) {
        EXPECT_EQ(seen.corners[k].id, set.views[i].corners[k].id);
        EXPECT_LT((seen.corners[k].pixel - set.views[i].corners[k].pixel).norm(), 1e-9);
        ++num_corners;
      }
    }
  }
  EXPECT_GT(num_corners, 2 * 15 * 33);
}

TEST(Robot, StandsAndMovesAsPeopleHaveIt) {
  int num_views = 0;
  double largest_tilt_deg = 0;
  double largest_distance_m = 0;
  for (const CameraOn camera_on : kBothPlaces) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const RobotSet set = simulateRobot(sceneOf(camera_on), seed);
      const double mount_m = set.mount_from_camera.translation.norm();
      if (camera_on == CameraOn::kHand) {
        EXPECT_GE(mount_m, 0.05);
        EXPECT_LE(mount_m, 0.12);
      } else {
        EXPECT_NEAR(mount_m, 1.08, 0.06);
        const Eigen::Vector3d ahead = set.mount_from_camera.rotation * Eigen::Vector3d::UnitZ();
        EXPECT_GT(ahead.dot(-Eigen::Vector3d::UnitX()), std::cos(16 * kRadPerDeg));
      }
      for (std::size_t i = 0; i < set.views.size(); ++i, ++num_views) {
        const SE3 pose = cameraFromBoard(set, set.base_from_gripper[i]);
        EXPECT_GE(set.views[i].corners.size(), 33U);  // of 54
        const Eigen::Vector3d middle = pose * set.scene.board.middle();
        const Eigen::Vector3d normal = pose.rotation * Eigen::Vector3d::UnitZ();
        EXPECT_GE(middle.norm(), 0.3 - 1e-9);
        EXPECT_LE(middle.norm(), 0.6 + 1e-9);
        largest_distance_m = std::max(largest_distance_m, middle.norm());
        largest_tilt_deg =
            std::max(largest_tilt_deg, std::acos(normal.dot(middle.normalized())) * kDegPerRad);
        // The robot reaches these poses: the gripper is above the table.
        const double height_m = set.base_from_gripper[i].translation.z();
        EXPECT_GT(height_m, camera_on == CameraOn::kHand ? 0.1 : -1);
      }
    }
  }
  EXPECT_EQ(num_views, 2 * 40 * 15);
  EXPECT_GT(largest_tilt_deg, 34);
  EXPECT_LE(largest_tilt_deg, 35 + 1e-6);
  EXPECT_GT(largest_distance_m, 0.59);
}

TEST(Robot, DeviatesByTheStatedNoise) {
  for (const CameraOn camera_on : kBothPlaces) {
    RobotScene scene = sceneOf(camera_on);
    scene.num_views = 1000;
    const RobotSet clean = simulateRobot(scene, 5);
    scene.robot_noise = {.rotation_rad = 2e-3, .translation_m = 1.5e-3};
    scene.corner_noise_px = 0.3;
    const RobotSet set = simulateRobot(scene, 5);
    EXPECT_EQ(difference(clean.base_from_gripper, set.base_from_gripper), 0);
    SE3::Tangent squares = SE3::Tangent::Zero();
    SE3::Tangent sum = SE3::Tangent::Zero();
    double corner_squares = 0;
    double num_corners = 0;
    for (std::size_t i = 0; i < 1000; ++i) {
      const SE3::Tangent deviation =
          (set.robot.poses[i].base_from_gripper.inverse() * set.base_from_gripper[i]).log();
      squares += deviation.cwiseAbs2() / 1000;
      sum += deviation / 1000;
      for (std::size_t k = 0; k < set.views[i].corners.size(); ++k, ++num_corners)
        corner_squares += (set.views[i].corners[k].pixel - clean.views[i].corners[k].pixel).squaredNorm();
    }
    for (int k = 0; k < 6; ++k) {
      const double sigma = k < 3 ? 1.5e-3 : 2e-3;
      EXPECT_NEAR(std::sqrt(squares[k]), sigma, 0.05 * sigma) << k;
      EXPECT_NEAR(sum[k], 0, 0.1 * sigma) << k;
    }
    EXPECT_NEAR(std::sqrt(corner_squares / (2 * num_corners)), 0.3, 0.005);
  }
}

TEST(Robot, MakesEachMistake) {
  int num_mistakes = 0;
  for (const CameraOn camera_on : kBothPlaces) {
    for (int i = 0; i <= static_cast<int>(RobotMistake::kMirroredImages); ++i, ++num_mistakes) {
      SCOPED_TRACE(i);
      const auto mistake = static_cast<RobotMistake>(i);
      const RobotSet right = simulateRobot(sceneOf(camera_on), 8);
      RobotSet set = right;
      Random random(static_cast<std::uint64_t>(i));
      apply(mistake, set, random);
      ASSERT_EQ(set.robot.poses.size(), 15U);
      std::size_t num_poses = 0;
      for (std::size_t k = 0; k < 15; ++k) {
        EXPECT_EQ(set.robot.poses[k].image, right.views[k].image);
        const SE3& pose = set.robot.poses[k].base_from_gripper;
        EXPECT_NEAR(pose.rotation.quaternion().norm(), 1, 1e-12);
        num_poses += difference(pose, right.robot.poses[k].base_from_gripper) > 1e-3 ? 1 : 0;
      }
      const bool is_mirrored = mistake == RobotMistake::kMirroredImages;
      const std::size_t changed = mistake == RobotMistake::kSwapped        ? 2
                                  : mistake == RobotMistake::kBoardMoved   ? 8
                                  : mistake == RobotMistake::kOnePoseWrong ? 1
                                  : is_mirrored                            ? 0
                                                                           : 15;
      EXPECT_EQ(num_poses, changed);
      EXPECT_EQ(set.views[3].corners[0].pixel != right.views[3].corners[0].pixel, is_mirrored);
      const bool is_reading = i < 4;
      ASSERT_EQ(set.robot.others.size(), is_reading ? 3U : 0U);
      int num_right = 0;
      for (const RobotReading& reading : set.robot.others) {
        EXPECT_FALSE(reading.how.empty());
        EXPECT_GT(difference(stated(reading.poses), stated(set.robot.poses)), 1e-3);
        num_right += difference(stated(reading.poses), stated(right.robot.poses)) == 0 ? 1 : 0;
      }
      EXPECT_EQ(num_right, is_reading ? 1 : 0);
    }
  }
  EXPECT_EQ(num_mistakes, 2 * 12);
}

TEST(Robot, SeesAMovedBoardInTheSameImages) {
  for (const CameraOn camera_on : kBothPlaces) {
    RobotScene scene = sceneOf(camera_on);
    scene.robot_noise = {.rotation_rad = 2e-3, .translation_m = 1.5e-3};
    const RobotSet right = simulateRobot(scene, 21);
    RobotSet set = right;
    Random random(4);
    apply(RobotMistake::kBoardMoved, set, random);
    for (std::size_t i = 0; i < 15; ++i) {
      const SE3 moved = cameraFromBoard(set, set.base_from_gripper[i]).inverse() *
                        cameraFromBoard(right, right.base_from_gripper[i]);
      EXPECT_NEAR(moved.translation.norm(), i < 7 ? 0 : 0.1, 1e-12);
      EXPECT_NEAR(moved.translation.z(), 0, 1e-12);
      EXPECT_NEAR(moved.rotation.log().norm(), i < 7 ? 0 : 5 * kRadPerDeg, 1e-12);
      // The robot's own error stays.
      const auto deviation = [i](const RobotSet& of) {
        return of.base_from_gripper[i].inverse() * of.robot.poses[i].base_from_gripper;
      };
      EXPECT_LT(difference(deviation(set), deviation(right)), 1e-12);
    }
  }
}

TEST(Robot, MirrorsRotationsWithTheirFrames) {
  const RobotSet right = simulateRobot(sceneOf(CameraOn::kHand), 2);
  RobotSet set = right;
  Random random(1);
  apply(RobotMistake::kLeftHanded, set, random);
  const Eigen::Matrix4d S = Eigen::Vector4d(1, 1, -1, 1).asDiagonal();
  for (std::size_t i = 0; i < 15; ++i) {
    const Eigen::Matrix4d expected = S * right.robot.poses[i].base_from_gripper.matrix() * S;
    EXPECT_LT((set.robot.poses[i].base_from_gripper.matrix() - expected).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Robot, MirroredImagesAreThoseOfABoardSeenFromTheFront) {
  RobotScene scene = sceneOf(CameraOn::kHand);
  // Its own mirror image, so that a pose must explain the mirrored corners.
  scene.camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 319.5, 239.5});
  RobotSet set = simulateRobot(scene, 2);
  std::vector<SE3> poses;
  for (const SE3& pose : set.base_from_gripper) poses.push_back(cameraFromBoard(set, pose));
  Random random(1);
  apply(RobotMistake::kMirroredImages, set, random);
  const Eigen::Matrix4d M = Eigen::Vector4d(-1, 1, 1, 1).asDiagonal();
  int num_corners = 0;
  for (std::size_t i = 0; i < 15; ++i) {
    Eigen::Matrix4d reversed = M;  // the board's own mirror image, about its middle
    reversed(0, 3) = 2 * scene.board.middle().x();
    const Eigen::Matrix4d pose = M * poses[i].matrix() * reversed;
    EXPECT_NEAR(pose.determinant(), 1, 1e-12);
    for (const Corner& corner : set.views[i].corners) {
      const Eigen::Vector3d p = (pose * scene.board.corner(corner.id).homogeneous()).head<3>();
      EXPECT_LT((scene.camera.project(p).pixel - corner.pixel).norm(), 1e-9);
      ++num_corners;
    }
  }
  EXPECT_GT(num_corners, 15 * 33);
}

TEST(Robot, FollowsTheSeedAndSaysWhenTheBoardIsTooLarge) {
  const RobotScene scene = sceneOf(CameraOn::kHand);
  const auto poses = [&](std::uint64_t seed) { return simulateRobot(scene, seed).base_from_gripper; };
  EXPECT_EQ(difference(poses(7), poses(7)), 0);
  EXPECT_GT(difference(poses(7), poses(8)), 0.01);
  RobotScene large = scene;
  large.board = Checkerboard{.columns = 9, .rows = 6, .square_m = 0.25};
  try {
    (void)simulateRobot(large, 1);
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    EXPECT_THAT(error.what(), testing::HasSubstr("smaller board"));
  }
}

}  // namespace
}  // namespace alidade
