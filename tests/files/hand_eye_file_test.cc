// SPDX-License-Identifier: MIT
#include "alidade/files/hand_eye_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/robot_table.h"
#include "support/message_of.h"
#include "support/mutator.h"
#include "support/scratch_folder.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

SE3 drawPose(std::mt19937& random) {
  std::uniform_real_distribution<double> draw(-1, 1);
  SE3::Tangent xi;
  for (double& value : xi) value = draw(random);
  xi.tail<3>() *= 1.8;
  return SE3::exp(xi);
}

HandEyeRecord drawRecord(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(0.1, 1);
  Eigen::Matrix<double, 6, 6> factor;
  for (double& value : factor.reshaped()) value = 1e-3 * draw(random);
  HandEyeRecord record{.camera_on = seed % 2 == 0 ? CameraOn::kHand : CameraOn::kBase,
                       .mount_from_camera = drawPose(random),
                       .covariance = factor * factor.transpose(),
                       .world_from_boards = {drawPose(random), drawPose(random)},
                       .boards = {"charuco:8x6:30mm:22mm:DICT_4X4_50", "chessboard:9x6:25mm"},
                       .robot_noise = {1e-4 * draw(random), 1e-3 * draw(random)},
                       .camera_name = "0042",
                       .num_poses = 20 + static_cast<int>(seed),
                       .error_m = 1e-3 * draw(random),
                       .rms_px = draw(random),
                       .verdict = Verdict::kReservations,
                       .findings = {"few_poses", "robot_noise"},
                       .created_by = "alidade 1.0: \"test\"",
                       .date = "2026-02-03"};
  record.covariance = record.covariance.selfadjointView<Eigen::Lower>();
  return record;
}

// Nothing but quaternions, which are normalised, may change, and these by the last digit.
void expectEqual(const SE3& a, const SE3& b) {
  EXPECT_EQ(a.translation, b.translation);
  const Eigen::Vector4d p = a.rotation.quaternion().coeffs();
  const Eigen::Vector4d q = b.rotation.quaternion().coeffs();
  EXPECT_LT(std::min((p - q).cwiseAbs().maxCoeff(), (p + q).cwiseAbs().maxCoeff()), 3e-16);
}
void expectSameNumber(double a, double b) {
  EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << a << " " << b;
}
void expectEqual(const HandEyeRecord& a, const HandEyeRecord& b) {
  EXPECT_EQ(a.camera_on, b.camera_on);
  expectEqual(a.mount_from_camera, b.mount_from_camera);
  EXPECT_EQ(a.covariance, b.covariance);
  ASSERT_EQ(a.world_from_boards.size(), b.world_from_boards.size());
  for (std::size_t i = 0; i < a.world_from_boards.size(); ++i)
    expectEqual(a.world_from_boards[i], b.world_from_boards[i]);
  EXPECT_EQ(a.boards, b.boards);
  EXPECT_EQ(a.robot_noise.rotation_rad, b.robot_noise.rotation_rad);
  EXPECT_EQ(a.robot_noise.translation_m, b.robot_noise.translation_m);
  EXPECT_EQ(a.camera_name, b.camera_name);
  EXPECT_EQ(a.num_poses, b.num_poses);
  expectSameNumber(a.error_m, b.error_m);
  expectSameNumber(a.rms_px, b.rms_px);
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.findings, b.findings);
  EXPECT_EQ(a.created_by, b.created_by);
  EXPECT_EQ(a.date, b.date);
}

TEST(HandEyeFile, ReadsWhatItWrites) {
  int num_checked = 0;
  for (std::uint32_t seed = 0; seed < 50; ++seed, ++num_checked) {
    const HandEyeRecord record = drawRecord(seed);
    expectEqual(parseHandEye(handEyeText(record), "handeye.yaml"), record);
  }
  EXPECT_EQ(num_checked, 50);
  const ScratchFolder scratch;
  const std::string path = scratch.write("handeye.yaml", handEyeText(drawRecord(3)));
  expectEqual(readHandEye(path), drawRecord(3));
}

TEST(HandEyeFile, NeedsNoCovarianceAndNoAccuracyOfARejectedCalibration) {
  HandEyeRecord record = drawRecord(1);
  record.covariance.setZero();
  record.boards.clear();
  record.world_from_boards.clear();
  record.findings.clear();
  expectEqual(parseHandEye(handEyeText(record), "h"), record);
  record.verdict = Verdict::kNo;
  record.error_m = record.rms_px = std::numeric_limits<double>::quiet_NaN();
  expectEqual(parseHandEye(handEyeText(record), "h"), record);
  record.verdict = Verdict::kReservations;
  EXPECT_NE(messageOf([&] { (void)parseHandEye(handEyeText(record), "h"); }).find("h:"), std::string::npos);
}

// The text with `from` replaced by `to`.
std::string edited(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(HandEyeFile, NamesFaultLineAndKey) {
  const HandEyeRecord record = drawRecord(2);
  const std::string text = handEyeText(record);
  const SE3& pose = record.mount_from_camera;
  struct Fault {
    std::string from;
    std::string to;
    std::string message;
  };
  const std::string x = exactText(pose.translation.x());
  const std::vector<Fault> kFaults = {
      {"alidade_handeye: 1", "alidade_handeye: 2", "h.yaml:1: alidade_handeye: found format version 2"},
      {"alidade_handeye: 1", "alidade_camera: 1", "without the key 'alidade_handeye'"},
      {"camera_on: hand", "camera_on: head", "h.yaml:2: camera_on: found 'head'"},
      {"camera_on: hand", "camera_on: base", "unknown key 'gripper_from_camera'"},
      {"num_poses:", "poses:", "unknown key 'poses'"},
      {"num_poses: 22\n", "", "no key 'num_poses'"},
      {"num_poses: 22", "num_poses: -1", "num_poses: found -1"},
      {"num_poses: 22", "num_poses: 22\nnum_poses: 22", "the key 'num_poses' twice"},
      {"  translation_m: [" + x, "  translation_m: [" + exactText(pose.translation.x() + 1e-8),
       "between the stated point and that of gripper_from_camera"},
      {"camera_m: [0.1", "camera_m: [0.2", "self_check: found 0.1"},
      {"  quaternion_xyzw: [", "  quaternion_xyzw: [1", "self_check: found "},
      {"  rotation_std_rad: [", "  rotation_std_rad: [1",
       "gripper_from_camera: found standard deviations that differ"},
      {"  rotation_std_rad:", "  x_rotation_std_rad:", "no key 'rotation_std_rad'"},
      {"rotation_rad: ", "rotation_rad: -", "robot_noise.rotation_rad: found -"},
      {"error_m: ", "error_m: nan #", "error_m: found 'nan'"},
      {"verdict: usable_with_reservations", "verdict: good", "verdict: found 'good'"},
      {"board: ", "plate: ", "no key 'board'"},
      {"findings: [", "findings: 1 # [", "findings: found '1'"},
  };
  int num_checked = 0;
  for (const auto& [from, to, message] : kFaults) {
    const std::string told = messageOf([&] { (void)parseHandEye(edited(text, from, to), "h.yaml"); });
    EXPECT_NE(told.find(message), std::string::npos) << told << "\n" << edited(text, from, to);
    EXPECT_EQ(told.find("h.yaml:"), 0U) << told;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 18);
  expectEqual(parseHandEye(edited(text, "num_poses", "x_note: {a: 1}\nnum_poses"), "h.yaml"), record);
}

// A damaged file is refused, or states the same transform, and all of a record that can be written again.
TEST(HandEyeFile, DamageIsFoundOrHarmless) {
  int num_read = 0;
  int num_refused = 0;
  for (std::uint32_t seed = 0; seed < 2500; ++seed) {
    const HandEyeRecord record = drawRecord(seed % 8);
    const std::string text = Mutator(seed)(handEyeText(record));
    try {
      const HandEyeRecord read = parseHandEye(text, "h.yaml");
      EXPECT_LT((read.mount_from_camera.matrix() - record.mount_from_camera.matrix()).norm(), 1e-7) << text;
      expectEqual(parseHandEye(handEyeText(read), "again"), read);
      ++num_read;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      EXPECT_EQ(std::string(error.what()).find("h.yaml"), 0U) << error.what();
      ++num_refused;
    }
  }
  EXPECT_EQ(num_read + num_refused, 2500);
  EXPECT_GT(num_read, 200);
  EXPECT_GT(num_refused, 1200);
}

TEST(HandEyeFile, WritesTheFormatsOfOtherPrograms) {
  EXPECT_EQ(handEyeFormats().size(), 4U);
  EXPECT_EQ(handEyeFormats().front().id, "alidade");
  HandEyeRecord record{.camera_on = CameraOn::kHand,
                       .mount_from_camera = {SO3::fromQuaternion({0.5, 0.5, -0.5, 0.5}), {0.1, -0.2, 0.3}},
                       .world_from_boards = {},
                       .boards = {},
                       .camera_name = "",
                       .findings = {},
                       .created_by = ""};
  EXPECT_EQ(
      handEyeText(record, "ros"),
      "# ros2 run tf2_ros static_transform_publisher --x 0.1 --y -0.2 --z 0.3 --qx 0.5 --qy -0.5 --qz 0.5 "
      "--qw 0.5 --frame-id gripper --child-frame-id camera\n"
      "# camera: x right, y down, z forward, an optical frame\n"
      "header:\n  frame_id: gripper\nchild_frame_id: camera\ntransform:\n"
      "  translation: {x: 0.1, y: -0.2, z: 0.3}\n  rotation: {x: 0.5, y: -0.5, z: 0.5, w: 0.5}\n");
  record.camera_on = CameraOn::kBase;
  EXPECT_EQ(handEyeText(record, "opencv"),
            "%YAML:1.0\n---\n"
            "R_cam2base: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
            "   data: [ 0, -1, 0, 0, 0, -1, 1, 0, 0 ]\n"
            "t_cam2base: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ 0.1, -0.2, 0.3 ]\n");
  try {
    (void)handEyeText(record, "udf");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_NE(std::string(error.what()).find("did you mean 'urdf'?"), std::string::npos) << error.what();
  }
}

// The numbers in quotes after `key`.
std::vector<double> attribute(const std::string& text, const std::string& key) {
  std::size_t at = text.find(key + "=\"");
  EXPECT_NE(at, std::string::npos) << text;
  at += key.size() + 2;
  std::vector<double> numbers;
  const std::string value = text.substr(at, text.find('"', at) - at);
  for (const std::string_view part : split(value, ' ')) numbers.push_back(parseDouble(part).value());
  return numbers;
}

TEST(HandEyeFile, UrdfTurnsAboutFixedAxes) {
  int num_checked = 0;
  for (std::uint32_t seed = 0; seed < 40; ++seed, ++num_checked) {
    const HandEyeRecord record = drawRecord(seed);
    const std::string text = handEyeText(record, "urdf");
    const std::string mount = seed % 2 == 0 ? "gripper" : "base";
    EXPECT_NE(text.find("<parent link=\"" + mount + "\"/>\n  <child link=\"camera\"/>"), std::string::npos)
        << text;
    const std::vector<double> rpy = attribute(text, "rpy");
    const std::vector<double> xyz = attribute(text, "xyz");
    ASSERT_EQ(rpy.size(), 3U);
    ASSERT_EQ(xyz.size(), 3U);
    const SO3 rotation = SO3::exp({0, 0, rpy[2]}) * SO3::exp({0, rpy[1], 0}) * SO3::exp({rpy[0], 0, 0});
    EXPECT_LT((rotation.matrix() - record.mount_from_camera.rotation.matrix()).norm(), 1e-14);
    EXPECT_EQ(Eigen::Vector3d(xyz.data()), record.mount_from_camera.translation);
  }
  EXPECT_EQ(num_checked, 40);
}

// The first block of docs/handeye.md that begins like this.
std::string documented(const std::string& begin) {
  std::ifstream file(sourcePath("docs/handeye.md"));
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  const std::size_t at = page.find(begin);
  EXPECT_NE(at, std::string::npos);
  return page.substr(at, page.find("```", at) - at);
}

TEST(HandEyeFile, OfTheDocumentationIsRead) {
  const HandEyeRecord record = parseHandEye(documented("alidade_handeye: 1"), "handeye.yaml");
  EXPECT_EQ(record.num_poses, 24);
  EXPECT_EQ(record.covariance(2, 2), 9e-8);
  EXPECT_EQ(record.boards.size(), 1U);
  EXPECT_EQ(parseRobotTable(documented("image,x_m"), "poses.csv").poses.size(), 2U);
}

}  // namespace
}  // namespace alidade
