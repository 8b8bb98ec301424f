// SPDX-License-Identifier: MIT
#include "alidade/handeye/doctor.h"

#include <gmock/gmock.h>

#include <array>
#include <cstdint>
#include <optional>
#include <ostream>
#include <set>
#include <string>

#include "alidade/handeye/hand_eye.h"
#include "robot_scenes.h"

namespace alidade {
namespace {

constexpr RobotNoise kUsualRobot{.rotation_rad = 2e-3, .translation_m = 1.5e-3};

HandEyeCalibration calibrated(const RobotSet& set, std::optional<CameraOn> camera_on) {
  HandEyeOptions options{.camera_on = camera_on};
  options.camera.model = "radtan";
  return calibrateHandEye(std::vector{set.scene.board}, set.views, set.robot, options);
}

// All findings but the one that follows from noise, and the note about what was not stated.
std::set<std::string> findingsOf(const HandEyeCalibration& result) {
  std::set<std::string> ids;
  for (const Diagnosis& diagnosis : result.diagnoses) {
    if (diagnosis.id == DiagnosisId("camera_on_found") && diagnosis.severity == Severity::kNote) continue;
    ids.insert(std::string(diagnosis.id));
  }
  ids.erase("hand_eye_inaccurate");
  return ids;
}

struct MistakeCase {
  RobotMistake mistake;
  std::string id;
};

void PrintTo(const MistakeCase& mistake, std::ostream* out) {
  *out << static_cast<int>(mistake.mistake) << ", " << mistake.id;
}

class Mistakes : public testing::TestWithParam<MistakeCase> {};

TEST_P(Mistakes, AreNamedAndNoOthers) {
  const auto& [mistake, id] = GetParam();
  int num_named = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RobotSet set = simulateRobot(robotScene(kBothPlaces[seed % 2], kUsualRobot, 0.1), seed);
    Random random(seed);
    apply(mistake, set, random);
    // Inverted poses are right ones for a camera at the other place.
    const HandEyeCalibration result = calibrated(set, set.scene.camera_on);
    std::set<std::string> findings = findingsOf(result);
    EXPECT_EQ(std::string(result.diagnoses.front().id), id) << seed;
    // What follows from these, and is said after them.
    if (id == "robot_poses_swapped" || id == "robot_contradicts") findings.erase("robot_poses_left_out");
    if (id == "robot_contradicts") findings.erase("not_converged");
    EXPECT_THAT(findings, testing::ElementsAre(id)) << seed;
    num_named += findings == std::set{id} ? 1 : 0;
    const bool is_failure = id == "robot_mirrored" || id == "robot_contradicts";
    if (is_failure) {
      EXPECT_FALSE(result.isUsable()) << seed;
    }
  }
  EXPECT_EQ(num_named, 20);
}

INSTANTIATE_TEST_SUITE_P(Doctor, Mistakes,
                         testing::Values(MistakeCase{RobotMistake::kQuaternionOrder, "robot_poses_misread"},
                                         MistakeCase{RobotMistake::kMillimetres, "robot_poses_misread"},
                                         MistakeCase{RobotMistake::kDegrees, "robot_poses_misread"},
                                         MistakeCase{RobotMistake::kEulerOrder, "robot_poses_misread"},
                                         MistakeCase{RobotMistake::kInverted, "robot_poses_inverted"},
                                         MistakeCase{RobotMistake::kLeftHanded, "robot_mirrored"},
                                         MistakeCase{RobotMistake::kOtherRecording, "robot_contradicts"},
                                         MistakeCase{RobotMistake::kShifted, "robot_poses_shifted"},
                                         MistakeCase{RobotMistake::kSwapped, "robot_poses_swapped"},
                                         MistakeCase{RobotMistake::kBoardMoved, "robot_board_moved"},
                                         MistakeCase{RobotMistake::kOnePoseWrong, "robot_poses_left_out"},
                                         MistakeCase{RobotMistake::kMirroredImages, "robot_mirrored"}));

TEST(Doctor, FindsNothingInSoundSets) {
  constexpr std::array kRobots = {RobotNoise{1e-4, 5e-5}, kUsualRobot, RobotNoise{5e-3, 3e-3}};
  int num_sets = 0;
  int num_without = 0;
  for (const CameraOn camera_on : kBothPlaces) {
    for (const RobotNoise& robot : kRobots) {
      for (std::uint64_t seed = 100; seed < 110; ++seed, ++num_sets) {
        const RobotSet set = simulateRobot(robotScene(camera_on, robot, 0.1), seed);
        const HandEyeCalibration result = calibrated(set, std::nullopt);
        EXPECT_EQ(result.camera_on, camera_on) << seed;
        EXPECT_THAT(findingsOf(result), testing::IsEmpty()) << seed << ", " << robot.rotation_rad;
        num_without += findingsOf(result).empty() ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(num_sets, 60);
  EXPECT_EQ(num_without, 60);
}

TEST(Doctor, TakesInvertedPosesAsThoseOfTheOtherPlaceIfNoneIsStated) {
  RobotSet set = simulateRobot(robotScene(CameraOn::kHand, kUsualRobot, 0.1), 1);
  Random random(1);
  apply(RobotMistake::kInverted, set, random);
  const HandEyeCalibration result = calibrated(set, std::nullopt);
  EXPECT_EQ(result.camera_on, CameraOn::kBase);
  EXPECT_THAT(findingsOf(result), testing::IsEmpty());
  EXPECT_EQ(result.diagnoses.back().id, DiagnosisId("camera_on_found"));
}

// Tilts about the middle of the board, without a roll and from one distance, fit either place of the camera.
TEST(Doctor, AsksWhereTheCameraIsIfThePosesDoNotTell) {
  int num_asked = 0;
  int num_wrong = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    const SE3 mount_from_camera{SO3::exp({0.1, -0.2, 1.5}), {0.05, -0.03, 0.08}};
    const SE3 world_from_board{SO3::exp({3.1, 0.1, 0}), {0.6, 0.1, 0.02}};
    std::vector<MatchedView> views;
    RobotTable table;
    for (const auto& [x, y] : {std::pair(0.0, 0.0), {0.4, 0.0}, {-0.4, 0.0}, {0.0, 0.4}, {0.0, -0.4}}) {
      const SE3 camera_from_board{SO3::exp({x, y, 0}), {0, 0, 0.4}};
      const SE3 motion = mount_from_camera * camera_from_board * world_from_board.inverse();
      SE3::Tangent noise;
      for (double& value : noise) value = 1e-3 * random.normal();
      views.push_back({.pose = table.poses.size(), .camera_from_board = camera_from_board});
      table.poses.push_back({.image = "", .base_from_gripper = motion.inverse() * SE3::exp(noise)});
    }
    const LikelyReading reading = likeliestReading(views, 1, table, std::nullopt);
    ASSERT_EQ(reading.diagnoses.size(), 1U);
    EXPECT_EQ(reading.diagnoses.front().id, DiagnosisId("camera_on_found"));
    const bool is_asked = reading.diagnoses.front().severity == Severity::kFailure;
    num_asked += is_asked ? 1 : 0;
    num_wrong += !is_asked && reading.camera_on != CameraOn::kHand ? 1 : 0;
    EXPECT_TRUE(likeliestReading(views, 1, table, CameraOn::kHand).diagnoses.empty());
  }
  EXPECT_EQ(num_asked, 40);
  EXPECT_EQ(num_wrong, 0);
}

// A robot knows metres, so that a wrong size of the squares shows.
TEST(Doctor, FindsAWrongSizeOfTheBoard) {
  int num_found = 0;
  int num_false = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const RobotSet set = simulateRobot(robotScene(kBothPlaces[seed % 2], {5e-4, 2e-4}, 0.1), seed);
    num_false += findingsOf(calibrated(set, set.scene.camera_on)).contains("robot_scale") ? 1 : 0;
    RobotSet wrong = set;
    wrong.scene.board = Checkerboard{.columns = 9, .rows = 6, .square_m = 0.0255};
    const HandEyeCalibration result = calibrated(wrong, set.scene.camera_on);
    num_found += findingsOf(result).contains("robot_scale") ? 1 : 0;
    for (const Diagnosis& diagnosis : result.diagnoses) {
      if (diagnosis.id == DiagnosisId("robot_scale")) {
        EXPECT_THAT(diagnosis.cause, testing::HasSubstr("smaller"));
      }
    }
  }
  EXPECT_EQ(num_found, 20);
  EXPECT_EQ(num_false, 0);
}

}  // namespace
}  // namespace alidade
