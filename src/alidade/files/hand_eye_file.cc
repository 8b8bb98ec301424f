// SPDX-License-Identifier: MIT
#include "alidade/files/hand_eye_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/alidade_format.h"
#include "alidade/files/formats/pose_numbers.h"
#include "alidade/files/text/file_text.h"
#include "alidade/files/text/pose_node.h"
#include "alidade/files/text/yaml_node.h"
#include "alidade/files/text/yaml_writer.h"
#include "alidade/geometry/rotation_conversions.h"

namespace alidade {
namespace {

using detail::YamlNode;

// Numbers that only a rejected calibration may lack.
std::optional<double> ifKnown(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string alidadeText(const HandEyeRecord& record) {
  using detail::flowMap, detail::quoted, detail::writeEntries;
  const Eigen::Vector3d point(0.1, 0.2, 1);
  const auto transform = [&record](YAML::Emitter& to) {
    const SE3& pose = record.mount_from_camera;
    to << YAML::BeginMap;
    writeEntries(to, "quaternion_xyzw", quaternionXyzw(pose.rotation), "translation_m", pose.translation);
    if (!record.covariance.isZero(0) && record.covariance.allFinite()) {
      const Eigen::Matrix<double, 6, 1> std = record.covariance.diagonal().cwiseSqrt();
      std::vector<double> triangle;
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j <= i; ++j) triangle.push_back(record.covariance(i, j));
      writeEntries(to, "rotation_std_rad", Eigen::Vector3d(std.tail<3>()), "translation_std_m",
                   Eigen::Vector3d(std.head<3>()), "covariance", detail::triangleRows(triangle));
    }
    to << YAML::EndMap;
  };
  const auto boards = [&record](YAML::Emitter& to) {
    to << YAML::BeginSeq;
    for (std::size_t i = 0; i < record.boards.size(); ++i) {
      const SE3& pose = record.world_from_boards.at(i);
      flowMap("board", quoted(record.boards[i]), "quaternion_xyzw", quaternionXyzw(pose.rotation),
              "translation_m", pose.translation)(to);
    }
    to << YAML::EndSeq;
  };
  const std::string mount = std::string(mountName(record.camera_on));
  YAML::Emitter out;
  out << YAML::BeginMap;
  writeEntries(out, "alidade_handeye", 1, "camera_on", cameraOnName(record.camera_on), mount + "_from_camera",
               transform, std::string(worldName(record.camera_on)) + "_from_board", boards, "robot_noise",
               flowMap("rotation_rad", record.robot_noise.rotation_rad, "translation_m",
                       record.robot_noise.translation_m),
               "num_poses", record.num_poses, "error_m", ifKnown(record.error_m), "rms_px",
               ifKnown(record.rms_px), "camera", quoted(record.camera_name), "verdict",
               verdictName(record.verdict), "findings", record.findings, "created_by",
               quoted(record.created_by), "date", quoted(record.date), "self_check",
               flowMap("camera_m", point, mount + "_m", Eigen::Vector3d(record.mount_from_camera * point)));
  out << YAML::EndMap;
  return detail::withBytesShown(detail::documentText(out));
}

std::string numbersText(const Eigen::MatrixXd& matrix, std::string_view separator = " ") {
  return join(mapped(detail::rowMajor(matrix), exactText), separator);
}

std::string rosText(const HandEyeRecord& record) {
  const std::string mount = std::string(mountName(record.camera_on));
  const auto t = mapped(record.mount_from_camera.translation, exactText);
  const auto q = mapped(quaternionXyzw(record.mount_from_camera.rotation), exactText);
  return fmt::format(
      "# ros2 run tf2_ros static_transform_publisher --x {1} --y {2} --z {3} --qx {4} --qy {5} --qz {6} --qw {7} "
      "--frame-id {0} --child-frame-id camera\n"
      "# camera: x right, y down, z forward, an optical frame\n"
      "header:\n  frame_id: {0}\nchild_frame_id: camera\ntransform:\n"
      "  translation: {{x: {1}, y: {2}, z: {3}}}\n  rotation: {{x: {4}, y: {5}, z: {6}, w: {7}}}\n",
      mount, t[0], t[1], t[2], q[0], q[1], q[2], q[3]);
}

std::string urdfText(const HandEyeRecord& record) {
  const EulerOrder fixed_xyz{.axes = {0, 1, 2}, .is_fixed = true};
  return fmt::format(
      "<joint name=\"{0}_to_camera\" type=\"fixed\">\n  <parent link=\"{0}\"/>\n  <child link=\"camera\"/>\n"
      "  <origin xyz=\"{1}\" rpy=\"{2}\"/>\n</joint>\n",
      std::string(mountName(record.camera_on)), numbersText(record.mount_from_camera.translation),
      numbersText(eulerFromRotation(record.mount_from_camera.rotation, fixed_xyz).angles_rad));
}

std::string opencvText(const HandEyeRecord& record) {
  const auto matrix = [&](const char* name, const Eigen::MatrixXd& values) {
    return fmt::format("{}_cam2{}: !!opencv-matrix\n   rows: 3\n   cols: {}\n   dt: d\n   data: [ {} ]\n",
                       name, std::string(mountName(record.camera_on)), values.cols(),
                       numbersText(values, ", "));
  };
  return "%YAML:1.0\n---\n" + matrix("R", record.mount_from_camera.rotation.matrix()) +
         matrix("t", record.mount_from_camera.translation);
}

constexpr std::array<HandEyeFormat, 4> kHandEyeFormats = {
    {{"alidade", "Alidade hand-eye file (YAML)", alidadeText},
     {"ros", "static transform of ROS (YAML)", rosText},
     {"urdf", "fixed joint of URDF (XML)", urdfText},
     {"opencv", "R and t of cv::calibrateHandEye (YAML)", opencvText}}};

double readLength(const YamlNode& node) {
  const double value = node.number();
  if (value < 0) throw node.error(node.text(), "0 or more");
  return value;
}

// Of the keys rotation_std_rad, translation_std_m and covariance, none may be missing.
void readCovariance(const YamlNode& node, Eigen::Matrix<double, 6, 6>& covariance) {
  const std::vector<double> triangle = detail::readTriangle(node.at("covariance"), 6);
  for (int i = 0, next = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j)
      covariance(i, j) = covariance(j, i) = triangle[static_cast<std::size_t>(next++)];
  Eigen::Matrix<double, 6, 1> std;
  std << detail::readVector(node.at("translation_std_m")), detail::readVector(node.at("rotation_std_rad"));
  if (!std.isApprox(covariance.diagonal().cwiseSqrt(), 1e-9))
    throw node.error("standard deviations that differ from 'covariance'", "the square roots of its diagonal");
}

void checkPoint(const YamlNode& node, const std::string& mount, const SE3& mount_from_camera) {
  node.allowKeys({"camera_m", mount + "_m"});
  const Eigen::Vector3d point = mount_from_camera * detail::readVector(node.at("camera_m"));
  const double distance = (point - detail::readVector(node.at(mount + "_m"))).norm();
  constexpr double kMaxDistance = 1e-9;
  if (distance <= kMaxDistance) return;
  throw node.error(exactText(distance) + " m between the stated point and that of " + mount + "_from_camera",
                   "the same point", "the file was changed: write it again with alidade handeye calibrate");
}

HandEyeRecord readRecord(const YamlNode& root) {
  if (!root.has("alidade_handeye"))
    throw root.error("a file without the key 'alidade_handeye'", "a hand-eye file of Alidade",
                     "write one with alidade handeye calibrate");
  detail::checkVersion(root.at("alidade_handeye"));
  HandEyeRecord record;
  const YamlNode on = root.at("camera_on");
  if (on.text() == cameraOnName(CameraOn::kBase)) record.camera_on = CameraOn::kBase;
  if (on.text() != cameraOnName(record.camera_on)) throw on.error("'" + on.text() + "'", "hand or base");
  const std::string mount = std::string(mountName(record.camera_on));
  const std::string boards = std::string(worldName(record.camera_on)) + "_from_board";
  root.allowKeys({"alidade_handeye", "camera_on", mount + "_from_camera", boards, "robot_noise", "num_poses",
                  "error_m", "rms_px", "camera", "verdict", "findings", "created_by", "date", "self_check"});
  const YamlNode transform = root.at(mount + "_from_camera");
  const std::vector<std::string> std_keys = {"rotation_std_rad", "translation_std_m", "covariance"};
  record.mount_from_camera = detail::readPose(transform, std_keys);
  const auto isStated = [&](const std::string& key) { return transform.has(key); };
  if (std::ranges::any_of(std_keys, isStated)) readCovariance(transform, record.covariance);
  for (const YamlNode& item : root.at(boards).items()) {
    record.boards.push_back(item.at("board").text());
    record.world_from_boards.push_back(detail::readPose(item, {"board"}));
  }
  const YamlNode noise = root.at("robot_noise");
  noise.allowKeys({"rotation_rad", "translation_m"});
  record.robot_noise = {readLength(noise.at("rotation_rad")), readLength(noise.at("translation_m"))};
  record.num_poses = detail::readCount(root.at("num_poses"));
  record.verdict = detail::readVerdict(root.at("verdict"));
  const auto knownAt = [&](const char* key) {
    const bool is_unknown = record.verdict == Verdict::kNo && root.at(key).isNull();
    return is_unknown ? std::numeric_limits<double>::quiet_NaN() : readLength(root.at(key));
  };
  record.error_m = knownAt("error_m");
  record.rms_px = knownAt("rms_px");
  record.camera_name = root.at("camera").text();
  record.findings = mapped(root.at("findings").items(), &YamlNode::text);
  record.created_by = root.at("created_by").text();
  record.date = root.at("date").text();
  checkPoint(root.at("self_check"), mount, record.mount_from_camera);
  return record;
}

}  // namespace

std::span<const HandEyeFormat> handEyeFormats() {
  return kHandEyeFormats;
}

std::string handEyeText(const HandEyeRecord& record, std::string_view format) {
  if (!record.mount_from_camera.translation.allFinite()) {
    throw inputError(
        {.where = "hand-eye calibration",
         .found = "no transform" + (record.findings.empty() ? "" : " (" + record.findings.front() + ")"),
         .expected = "a solution to write"});
  }
  const auto found = std::ranges::find(kHandEyeFormats, format, &HandEyeFormat::id);
  if (found != kHandEyeFormats.end()) return found->write(record);
  const auto known = mapped(kHandEyeFormats, [](const HandEyeFormat& each) { return std::string(each.id); });
  throw usageError({"format of hand-eye files", "'" + std::string(format) + "'",
                    "one of " + join(known, ", "), didYouMean(format, known)});
}

HandEyeRecord parseHandEye(const std::string& text, const std::string& name) {
  detail::checkUtf8(text, name);
  return readRecord(YamlNode::parse(text, name));
}

HandEyeRecord readHandEye(const std::string& path) {
  return readRecord(YamlNode::readFile(path));
}

}  // namespace alidade
