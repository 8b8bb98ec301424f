// SPDX-License-Identifier: MIT
#include "alidade/handeye/hand_eye.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>

#include "alidade/core/cancel.h"
#include "alidade/core/degrees.h"
#include "alidade/simulate/observe.h"
#include "robot_scenes.h"
#include "support/message_of.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr RobotNoise kGoodRobot{.rotation_rad = 5e-4, .translation_m = 2e-4};

HandEyeOptions radtan() {
  HandEyeOptions options{.tolerance_m = 5e-3};
  options.camera.model = "radtan";
  return options;
}

HandEyeCalibration calibrated(const RobotSet& set, const HandEyeOptions& options = radtan()) {
  return calibrateHandEye(std::vector{set.scene.board}, set.views, set.robot, options);
}

RobotSet goodSet(CameraOn camera_on = CameraOn::kHand, std::uint64_t seed = 5) {
  return simulateRobot(robotScene(camera_on, kGoodRobot, 0.1), seed);
}

double shiftOf(const RobotSet& set, const HandEyeCalibration& result) {
  return (set.mount_from_camera.translation - result.mount_from_camera.translation).norm();
}

std::vector<std::string> idsOf(const HandEyeCalibration& result) {
  std::vector<std::string> ids;
  for (const Diagnosis& diagnosis : result.diagnoses) ids.emplace_back(diagnosis.id);
  std::erase(ids, "camera_on_found");  // where the test does not state it
  return ids;
}

TEST(HandEye, IsAsAccurateAsItSays) {
  struct Cell {
    RobotNoise robot;
    double corners_px;
  };
  int num_sets = 0;
  for (const auto& [robot, corners_px] :
       {Cell{{1e-4, 5e-5}, 0.05}, Cell{{5e-4, 2e-4}, 0.1}, Cell{{2e-3, 1.5e-3}, 0.3}}) {
    for (const CameraOn camera_on : kBothPlaces) {
      int num_covered = 0;
      constexpr int kNumSets = 10;
      for (std::uint64_t seed = 0; seed < kNumSets; ++seed, ++num_sets) {
        const RobotSet set = simulateRobot(robotScene(camera_on, robot, corners_px), seed);
        const HandEyeCalibration result = calibrated(set);
        EXPECT_EQ(result.camera_on, camera_on);
        const Eigen::Vector3d ahead(0, 0, result.board_distance_m);
        const double error = (set.mount_from_camera * ahead - result.mount_from_camera * ahead).norm();
        EXPECT_LT(error, 2.5 * result.error_m) << seed;
        num_covered += error < result.error_m ? 1 : 0;
        const SE3::Tangent sigmas = result.covariance.topLeftCorner<6, 6>().diagonal().cwiseSqrt();
        const SE3::Tangent errors = differenceOf(set.mount_from_camera, result.mount_from_camera);
        EXPECT_LT(errors.cwiseQuotient(sigmas).cwiseAbs().maxCoeff(), 4.5) << seed;
        EXPECT_EQ(result.frames.size(), 15U);
        EXPECT_EQ(result.covariance.rows(), 12);
      }
      EXPECT_GE(num_covered, 8);
    }
  }
  EXPECT_EQ(num_sets, 3 * 2 * 10);
}

TEST(HandEye, MatchesPosesByNameStemNumberOrOrder) {
  const RobotSet set = goodSet();
  const HandEyeCalibration by_name = calibrated(set);
  ASSERT_THAT(idsOf(by_name), IsEmpty());
  const auto renamed = [&](const std::function<std::string(int)>& nameOf) {
    RobotSet other = set;
    for (int i = 0; i < 15; ++i) other.robot.poses[static_cast<std::size_t>(i)].image = nameOf(i);
    return other;
  };
  const std::string zeros = "000";
  for (const RobotSet& other :
       {renamed([&](int i) { return (zeros + std::to_string(i)).substr(std::to_string(i).size()) + ".txt"; }),
        renamed([](int i) { return "pose" + std::to_string(i); }),
        renamed([](int i) { return std::to_string(i); })}) {
    RobotSet reversed = other;
    std::ranges::reverse(reversed.robot.poses);
    const HandEyeCalibration result = calibrated(reversed);
    EXPECT_THAT(idsOf(result), IsEmpty());
    EXPECT_LT(differenceOf(by_name.mount_from_camera, result.mount_from_camera).norm(), 1e-9);
  }
  for (const RobotSet& other : {renamed([](int) { return ""; }),
                                renamed([](int i) { return std::string(1, static_cast<char>('a' + i)); })}) {
    const HandEyeCalibration result = calibrated(other);
    EXPECT_THAT(idsOf(result), testing::ElementsAre("robot_poses_by_order"));
    EXPECT_EQ(result.verdict(), Verdict::kTrustworthy);
    EXPECT_LT(differenceOf(by_name.mount_from_camera, result.mount_from_camera).norm(), 1e-9);
  }
}

// An image without a board counts too.
TEST(HandEye, MatchesPosesByTheOrderOfAllImages) {
  RobotSet set = goodSet();
  HandEyeOptions options = radtan();
  for (const View& view : set.views) options.images.push_back(view.image);
  set.views.erase(set.views.begin() + 4);
  const HandEyeCalibration by_name = calibrated(set);
  for (RobotPose& pose : set.robot.poses) pose.image.clear();
  EXPECT_THAT(messageOf([&] { (void)calibrated(set); }),
              HasSubstr("15 poses, the first of '', for 14 images"));
  const HandEyeCalibration result = calibrated(set, options);
  EXPECT_THAT(idsOf(result), testing::ElementsAre("robot_poses_by_order"));
  EXPECT_EQ(result.frames.size(), 14U);
  EXPECT_LT(differenceOf(by_name.mount_from_camera, result.mount_from_camera).norm(), 1e-9);
}

// A log with rows before and after each image, on the path between them.
RobotTable logAround(const std::vector<RobotPose>& poses, double first_s,
                     const std::function<std::string(double)>& nameOf) {
  RobotTable log;
  const SE3::Tangent step = (SE3::Tangent() << 0.02, -0.01, 0.03, 0.1, 0.05, -0.08).finished();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double time = first_s + static_cast<double>(i);
    for (const double apart : {-0.25, 0.25})
      log.poses.push_back({nameOf(time + apart), poses[i].base_from_gripper * SE3::exp(apart * step)});
  }
  return log;
}

TEST(HandEye, MatchesPosesByTime) {
  const HandEyeCalibration by_name = calibrated(goodSet());
  constexpr double kFirst = 1700000000.25;
  const auto seconds = [](double time) { return std::to_string(time); };
  const auto nanoseconds = [](double time) {
    return std::to_string(static_cast<std::int64_t>(time * 1e6)) + "000";
  };
  const std::vector<std::function<std::string(double)>> names = {seconds, nanoseconds};
  int num_matched = 0;
  int num_refused = 0;
  for (const auto& of_image : names) {
    for (const auto& of_row : names) {
      RobotSet set = goodSet();
      for (std::size_t i = 0; i < set.views.size(); ++i)
        set.views[i].image = "cam_" + of_image(kFirst + static_cast<double>(i)) + ".png";
      const std::vector<RobotPose> poses = set.robot.poses;
      set.robot = logAround(poses, kFirst, of_row);
      const HandEyeCalibration result = calibrated(set);
      EXPECT_THAT(idsOf(result), testing::ElementsAre("robot_poses_by_time"));
      EXPECT_EQ(result.frames.size(), 15U);
      EXPECT_LT(differenceOf(by_name.mount_from_camera, result.mount_from_camera).norm(), 1e-6);
      ++num_matched;
      // Another clock.
      set.robot = logAround(poses, kFirst + 1000, of_row);
      EXPECT_THAT(messageOf([&] { (void)calibrated(set); }), HasSubstr("a pose for each image"));
      ++num_refused;
    }
  }
  EXPECT_EQ(num_matched, 4);
  EXPECT_EQ(num_refused, 4);
}

// Images from suggested poses lower the error more than images from others.
TEST(HandEye, SuggestsPosesThatHelp) {
  double squares_suggested = 0;
  double squares_random = 0;
  double expected = 0;
  constexpr int kNumSets = 4;
  for (std::uint64_t seed = 0; seed < kNumSets; ++seed) {
    for (const CameraOn camera_on : kBothPlaces) {
      RobotScene scene = robotScene(camera_on, kGoodRobot, 0.1);
      scene.num_views = 13;
      const RobotSet all = simulateRobot(scene, seed);
      RobotSet set = all;
      set.views.resize(8);
      set.robot.poses.resize(8);
      HandEyeOptions options = radtan();
      options.camera_on = camera_on;
      Random random(100 + seed);
      for (int k = 0; k < 5; ++k) {
        const HandEyeCalibration result = calibrated(set, options);
        ASSERT_TRUE(result.next_pose);
        EXPECT_LT(result.next_pose->error_m, result.error_m);
        const SE3 gripper = result.next_pose->base_from_gripper;
        const SE3 motion = camera_on == CameraOn::kHand ? gripper.inverse() : gripper;
        View view = exactView(scene.camera, scene.size, scene.board,
                              all.mount_from_camera.inverse() * motion * all.world_from_boards[0],
                              "next" + std::to_string(k) + ".png");
        addCornerNoise(view, scene.corner_noise_px, random);
        set.views.push_back(view);
        SE3::Tangent noise;
        for (int i = 0; i < 6; ++i)
          noise(i) = random.normal() * (i < 3 ? kGoodRobot.translation_m : kGoodRobot.rotation_rad);
        set.robot.poses.push_back({view.image, gripper * SE3::exp(noise)});
        expected += result.next_pose->error_m / result.error_m / (kNumSets * 2 * 5);
      }
      squares_suggested += std::pow(calibrated(set, options).error_m, 2);
      squares_random += std::pow(calibrated(all, options).error_m, 2);
    }
  }
  std::printf(
      "error after five suggested poses over that after five random ones: %.2f; expected for each: %.2f\n",
      std::sqrt(squares_suggested / squares_random), expected);
  EXPECT_LT(squares_suggested, 0.8 * squares_random);
}

TEST(HandEye, LeavesOutImagesWithoutAPose) {
  RobotSet set = goodSet();
  set.robot.poses.erase(set.robot.poses.begin() + 4);
  const HandEyeCalibration result = calibrated(set);
  EXPECT_EQ(result.frames.at(4).reason, "no robot pose");
  EXPECT_THAT(result.frames.at(5).reason, IsEmpty());
  EXPECT_LT(shiftOf(set, result), 1e-3);
  EXPECT_EQ(recordOf(result, "").num_poses, 14);
}

TEST(HandEye, SaysWhyItCannotBegin) {
  const auto refusalOf = [](const std::function<void(RobotSet&)>& change) {
    RobotSet set = goodSet();
    change(set);
    return messageOf([&] { (void)calibrated(set); });
  };
  EXPECT_THAT(refusalOf([](RobotSet& set) { set.robot.poses.resize(2); }),
              AllOf(HasSubstr("robot poses"), HasSubstr("2 poses"), HasSubstr("15 images")));
  EXPECT_THAT(refusalOf([](RobotSet& set) { set.robot.poses.clear(); }), HasSubstr("0 poses"));
  EXPECT_THAT(refusalOf([](RobotSet& set) {
                set.robot.poses.pop_back();
                for (RobotPose& pose : set.robot.poses) pose.image = "x";
              }),
              AllOf(HasSubstr("first of 'x'"), HasSubstr("'000.png'"), HasSubstr("first column")));
}

TEST(HandEye, KeepsAGivenLens) {
  const RobotSet set = goodSet();
  HandEyeOptions options = radtan();
  options.camera.initial = {.camera = set.scene.camera, .size = set.scene.size};
  for (const std::string_view name : set.scene.camera.parameterNames())
    options.camera.held.emplace_back(name);
  const HandEyeCalibration held = calibrated(set, options);
  EXPECT_EQ(onlyCamera(held.fit).params, fitParams(set.scene.camera));
  EXPECT_THAT(idsOf(held), IsEmpty());
  const HandEyeCalibration found = calibrated(set);
  EXPECT_NE(onlyCamera(found.fit).params, fitParams(set.scene.camera));
  EXPECT_LT(held.error_m, found.error_m);
  EXPECT_LT(shiftOf(set, held), 5e-4);
}

TEST(HandEye, EstimatesAMovedBoardAtBothPlaces) {
  for (const CameraOn camera_on : kBothPlaces) {
    RobotSet set = goodSet(camera_on);
    Random random(2);
    apply(RobotMistake::kBoardMoved, set, random);
    const HandEyeCalibration result = calibrated(set);
    EXPECT_THAT(idsOf(result), testing::Contains("robot_board_moved"));
    ASSERT_EQ(result.world_from_boards.size(), 2U);
    const SE3 moved = result.world_from_boards[0].inverse() * result.world_from_boards[1];
    EXPECT_NEAR(moved.translation.norm(), 0.1, 2e-3);
    EXPECT_NEAR(moved.rotation.log().norm(), 5 * kRadPerDeg, 2e-3);
    EXPECT_LT(shiftOf(set, result), 2e-3);
    EXPECT_EQ(result.covariance.rows(), 18);
    EXPECT_EQ(recordOf(result, "").boards.size(), 2U);
  }
}

TEST(HandEye, LeavesOutAWrongPoseAndSaysSo) {
  for (const CameraOn camera_on : kBothPlaces) {
    RobotSet set = goodSet(camera_on);
    Random random(3);
    const RobotTable right = set.robot;
    apply(RobotMistake::kOnePoseWrong, set, random);
    const HandEyeCalibration result = calibrated(set);
    int num_out = 0;
    for (std::size_t i = 0; i < 15; ++i) {
      const bool is_wrong =
          differenceOf(right.poses[i].base_from_gripper, set.robot.poses[i].base_from_gripper).norm() > 0;
      EXPECT_EQ(!result.frames.at(i).reason.empty(), is_wrong) << i;
      num_out += is_wrong ? 1 : 0;
    }
    EXPECT_EQ(num_out, 1);
    EXPECT_LT(shiftOf(set, result), 1e-3);
  }
}

TEST(HandEye, NamesTheImagesOfSwappedPoses) {
  RobotSet set = goodSet();
  std::swap(set.robot.poses[3].base_from_gripper, set.robot.poses[8].base_from_gripper);
  const HandEyeCalibration result = calibrated(set);
  EXPECT_THAT(result.frames.at(3).reason, HasSubstr("008.png"));
  EXPECT_THAT(result.frames.at(8).reason, HasSubstr("003.png"));
  EXPECT_LT(shiftOf(set, result), 1e-3);
}

TEST(HandEye, TakesSeveralBoardsInAnImage) {
  for (const CameraOn camera_on : kBothPlaces) {
    const RobotSet set = goodSet(camera_on);
    const Board other = Checkerboard{.columns = 5, .rows = 4, .square_m = 0.02};
    const SE3 world_from_other = set.world_from_boards[0] * SE3{SO3::exp({0.1, 0, 1}), {0.05, 0.02, -0.02}};
    std::vector<View> views = set.views;
    Random noise(9);
    for (std::size_t i = 0; i < 15; ++i) {
      View view = exactView(set.scene.camera, set.scene.size, other,
                            cameraFromBoard(set, i, world_from_other), set.views[i].image);
      if (view.corners.size() < 10) continue;
      addCornerNoise(view, 0.1, noise);
      view.board = 1;
      views.push_back(std::move(view));
    }
    ASSERT_GT(views.size(), 25U);
    const HandEyeCalibration result =
        calibrateHandEye(std::vector{set.scene.board, other}, views, set.robot, radtan());
    EXPECT_THAT(idsOf(result), IsEmpty());
    ASSERT_EQ(result.world_from_boards.size(), 2U);
    EXPECT_LT(differenceOf(world_from_other, result.world_from_boards[1]).norm(), 3e-3);
    EXPECT_LT(shiftOf(set, result), 1e-3);
    EXPECT_LT(result.error_m, calibrated(set).error_m);
    EXPECT_EQ(result.frames.size(), 15U);
  }
}

TEST(HandEye, JudgesBySizeOfErrorAndTolerance) {
  const RobotSet set = goodSet();
  HandEyeOptions options = radtan();
  const double error_m = calibrated(set).error_m;
  for (const auto& [factor, verdict] :
       {std::pair{1.01, Verdict::kTrustworthy}, std::pair{0.99, Verdict::kReservations},
        std::pair{0.21, Verdict::kReservations}, std::pair{0.19, Verdict::kNo}}) {
    options.tolerance_m = factor * error_m;
    EXPECT_EQ(calibrated(set, options).verdict(), verdict) << factor;
  }
}

TEST(HandEye, RefusesTurnsAboutOneAxis) {
  RobotSet set = goodSet();
  Random random(4);
  const SE3 first = set.base_from_gripper[0];
  for (std::size_t i = 0; i < set.views.size(); ++i) {
    // About the board's normal, and along its plane.
    const SE3 turned{SO3::exp({0, 0, random.uniform(-0.5, 0.5)}), {random.uniform(-0.03, 0.03), 0, 0}};
    set.base_from_gripper[i] = set.world_from_boards[0] * turned * set.world_from_boards[0].inverse() * first;
    set.robot.poses[i].base_from_gripper = set.base_from_gripper[i];
    set.views[i] = exactView(set.scene.camera, set.scene.size, set.scene.board,
                             cameraFromBoard(set, i, set.world_from_boards[0]), set.views[i].image);
    addCornerNoise(set.views[i], 0.1, random);
  }
  HandEyeOptions options = radtan();
  options.camera.initial = {.camera = set.scene.camera, .size = set.scene.size};
  for (const std::string_view name : set.scene.camera.parameterNames())
    options.camera.held.emplace_back(name);
  const HandEyeCalibration result = calibrated(set, options);
  EXPECT_EQ(idsOf(result).front(), "robot_motion_poor");
  EXPECT_FALSE(result.isUsable());
}

TEST(HandEye, IsRecordedWithItsFindings) {
  const RobotSet set = simulateRobot(robotScene(CameraOn::kBase, {2e-3, 1.5e-3}, 0.1), 5);
  HandEyeOptions options = radtan();
  options.tolerance_m = 1e-3;
  const HandEyeCalibration result = calibrated(set, options);
  const HandEyeRecord record = recordOf(result, "a test");
  EXPECT_EQ(record.camera_on, CameraOn::kBase);
  EXPECT_EQ(differenceOf(result.mount_from_camera, record.mount_from_camera).norm(), 0);
  EXPECT_EQ(record.covariance, (result.covariance.topLeftCorner<6, 6>()));
  EXPECT_EQ(record.boards, std::vector<std::string>{"checkerboard:9x6:25mm"});
  EXPECT_EQ(record.num_poses, 15);
  EXPECT_EQ(record.error_m, result.error_m);
  EXPECT_GT(record.rms_px, 0.1);
  EXPECT_EQ(record.verdict, Verdict::kReservations);
  EXPECT_EQ(record.findings, std::vector<std::string>{"hand_eye_inaccurate"});
  EXPECT_EQ(record.created_by, "a test");
}

TEST(HandEye, StopsWhenAsked) {
  const CancelFlag cancel{true};
  HandEyeOptions options = radtan();
  options.camera.cancel = &cancel;
  EXPECT_THROW((void)calibrated(goodSet(), options), Cancelled);
}

}  // namespace
}  // namespace alidade
