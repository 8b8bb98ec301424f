// SPDX-License-Identifier: MIT
#include "alidade/files/text/pose_node.h"

#include <algorithm>
#include <numbers>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/text/yaml_writer.h"
#include "alidade/geometry/rotation_conversions.h"

namespace alidade::detail {
namespace {

const std::vector<std::string> kRotationKeys =
    words("quaternion_xyzw quaternion_wxyz rotation_vector_rad rotation_matrix euler_zyx_rad euler_zyx_deg");

// A matrix written as rows, or as one list of numbers, row by row.
template <int kSize>
Eigen::Matrix<double, kSize, kSize> matrixOf(const YamlNode& node) {
  const std::vector<YamlNode> rows = node.items();
  std::vector<double> all;
  if (rows.size() != kSize) {
    all = node.numbers(kSize * kSize);
  } else {
    for (const YamlNode& row : rows) {
      for (const double value : row.numbers(kSize)) all.push_back(value);
    }
  }
  return Eigen::Map<const Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>>(all.data());
}

// Conversion errors do not know their place in the file, so it is added.
SO3 readRotation(const YamlNode& value, const std::string& key) {
  if (key == "rotation_matrix") {
    const Eigen::Matrix3d matrix = matrixOf<3>(value);
    return withPlace(value.where(), [&] { return rotationFromMatrix(matrix); });
  }
  const std::vector<double> v = value.numbers(key.starts_with("quaternion") ? 4 : 3);
  return withPlace(value.where(), [&] {
    if (key == "quaternion_xyzw") return SO3::fromQuaternion({v[3], v[0], v[1], v[2]});
    if (key == "quaternion_wxyz") return SO3::fromQuaternion({v[0], v[1], v[2], v[3]});
    if (key == "rotation_vector_rad") return SO3::exp({v[0], v[1], v[2]});
    const double unit = key == "euler_zyx_deg" ? std::numbers::pi / 180 : 1.0;
    return rotationFromEuler({.yaw_rad = v[0] * unit, .pitch_rad = v[1] * unit, .roll_rad = v[2] * unit});
  });
}

}  // namespace

SE3 readPose(const YamlNode& node, const std::vector<std::string>& beside) {
  std::vector<std::string> allowed = kRotationKeys;
  allowed.insert(allowed.end(), {"translation_m", "matrix"});
  allowed.insert(allowed.end(), beside.begin(), beside.end());
  node.allowKeys(allowed);
  if (node.has("matrix")) {
    for (const std::string& key : node.keys()) {
      if (key == "translation_m" || std::count(kRotationKeys.begin(), kRotationKeys.end(), key) > 0)
        throw node.error("'matrix' and '" + key + "'",
                         "only 'matrix', which already contains the whole pose");
    }
    const Eigen::Matrix4d matrix = matrixOf<4>(node.at("matrix"));
    return withPlace(node.at("matrix").where(), [&] { return motionFromMatrix(matrix); });
  }
  std::string rotation_key;
  for (const std::string& key : kRotationKeys) {
    if (!node.has(key)) continue;
    if (!rotation_key.empty()) throw node.error("both " + rotation_key + " and " + key, "only one rotation");
    rotation_key = key;
  }
  if (rotation_key.empty())
    throw node.error("no rotation", "one of " + join(kRotationKeys, ", ") + ", or matrix");
  SE3 pose;
  pose.rotation = readRotation(node.at(rotation_key), rotation_key);
  const std::vector<double> t = node.at("translation_m").numbers(3);
  pose.translation = {t[0], t[1], t[2]};
  return pose;
}

std::optional<SE3> readFramedPose(const YamlNode& node, const std::vector<std::string>& beside) {
  for (const char* frame : {"world", "board", "rig"}) {
    const std::string forward = std::string("camera_from_") + frame;
    const std::string backward = std::string(frame) + "_from_camera";
    for (const std::string& key : {forward, backward}) {
      if (!node.has(key)) continue;
      std::vector<std::string> allowed = beside;
      allowed.push_back(key);
      node.allowKeys(allowed);
      const SE3 pose = readPose(node.at(key));
      return key == forward ? pose : pose.inverse();
    }
  }
  return std::nullopt;
}

void writePose(YAML::Emitter& out, const SE3& pose) {
  Eigen::Vector4d q = pose.rotation.quaternion().coeffs();
  if (q.w() < 0) q = -q;
  flowMap("quaternion_xyzw", q, "translation_m", pose.translation)(out);
}

}  // namespace alidade::detail
