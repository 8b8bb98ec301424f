// SPDX-License-Identifier: MIT
#include "alidade/files/text/pose_node.h"

#include <algorithm>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/text/yaml_writer.h"
#include "alidade/geometry/rotation_conversions.h"

namespace alidade::detail {
namespace {

// The keys by which a program writes a pose.
struct PoseKeys {
  std::string rotation{};
  std::string translation{};  // empty if the rotation's value holds it
  std::string form{};         // of the rotation's value
  std::string frames{};       // if the program always means these
  bool are_maps = false;      // {x: 0, y: 0, z: 0, w: 1}
};
// Those of OpenCV, ROS (Pose, Transform), many scripts, and nerfstudio, whose camera has OpenGL's axes.
const std::vector<PoseKeys> kOtherKeys = {{"rvec", "tvec", "rotation_vector_rad", "camera_from_object"},
                                          {"orientation", "position", "quaternion_xyzw", "", true},
                                          {"rotation", "translation", "quaternion_xyzw", "", true},
                                          {"R", "t", "rotation_matrix"},
                                          {"R", "T", "rotation_matrix"},
                                          {"transform_matrix", "", "matrix", "world_from_camera"}};

// Keys whose meaning differs between programs, and what to write instead.
struct Replacement {
  const char* keys;
  const char* instead;
};
constexpr Replacement kReplacements[] = {
    {"quaternion quat q orientation rotation",
     "quaternion_xyzw: [x, y, z, w], or quaternion_wxyz: [w, x, y, z]"},
    {"rpy roll pitch yaw", "euler_fixed_xyz_rad: [roll, pitch, yaw], or euler_fixed_xyz_deg"},
    {"euler euler_angles", "euler_zyx_deg: [yaw, pitch, roll], or another order, such as euler_xyz_deg"},
    {"axis angle", "axis_angle_deg: [x, y, z, angle]"},
    {"translation position t xyz location tvec", "translation_m: [x, y, z] in metres, and a rotation"},
    {"T transform extrinsic extrinsics pose", "matrix: 4x4, under a key such as camera_from_world"}};

// A list of numbers, a list of rows, or as ROS writes them a map of x, y, z and w.
std::vector<double> numbersIn(const YamlNode& node, std::size_t count, bool is_map) {
  if (is_map) {
    const std::vector<std::string> names = words(count == 4 ? "x y z w" : "x y z");
    node.allowKeys(names);
    return mapped(names, [&](const std::string& key) { return node.at(key).number(); });
  }
  const std::vector<YamlNode> rows = node.items();
  if (rows.empty() || !rows.front().isSequence() || count % rows.size() != 0) return node.numbers(count);
  std::vector<double> all;
  for (const YamlNode& row : rows)
    std::ranges::copy(row.numbers(count / rows.size()), std::back_inserter(all));
  return all;
}

NamedPose readKeys(const YamlNode& node, const PoseKeys& keys, bool is_any) {
  const YamlNode rotation = node.at(keys.rotation);
  const PoseForm form = findPoseForm(keys.form).value();
  const std::vector<double> numbers = numbersIn(rotation, form.places.size(), keys.are_maps);
  // Errors of a form do not know their place in the file, so it is added.
  NamedPose pose = withPlace(rotation.where(), [&] { return form.read(numbers); });
  pose.frames = keys.frames;
  if (keys.rotation == "transform_matrix")
    pose.stated.rotation = pose.stated.rotation * SO3::fromQuaternion({0, 1, 0, 0});
  if (pose.has_translation || (is_any && !node.has(keys.translation))) return pose;
  pose.stated.translation = Eigen::Vector3d(numbersIn(node.at(keys.translation), 3, keys.are_maps).data());
  pose.has_translation = true;
  return pose;
}

NamedPose readUnframed(const YamlNode& node, std::vector<std::string> allowed, bool is_any) {
  for (const PoseKeys& keys : kOtherKeys) {
    if (!node.has(keys.rotation) || node.at(keys.rotation).isMap() != keys.are_maps ||
        !(keys.translation.empty() || node.has(keys.translation) || (is_any && node.keys().size() == 1)))
      continue;
    allowed.insert(allowed.end(), {keys.rotation, keys.translation});
    node.allowKeys(allowed);
    return readKeys(node, keys, is_any);
  }
  PoseKeys found{.translation = "translation_m"};
  const std::vector<std::string> forms = mapped(poseForms(), &PoseForm::name);
  for (const std::string& key : node.isMap() ? node.keys() : std::vector<std::string>()) {
    if (std::ranges::count(allowed, key) > 0) continue;
    for (const auto& [keys, instead] : kReplacements) {
      if (std::ranges::count(words(keys), key) > 0)
        throw node.at(key).error("unknown key '" + key + "'", instead);
    }
    if (findPoseForm(key + "_deg"))
      throw node.at(key).error("no unit", "degrees or radians", poseFormAdvice(key));
    if (!findPoseForm(key)) continue;
    if (!found.form.empty()) throw node.error("both " + found.form + " and " + key, "only one rotation");
    found.form = found.rotation = key;
  }
  allowed.push_back(found.translation);
  if (!found.form.empty()) allowed.push_back(found.rotation);
  allowed.insert(allowed.end(), forms.begin(), forms.end());
  node.allowKeys(allowed);
  if (found.form.empty()) throw node.error("no rotation", "one of " + join(forms, ", "));
  if (findPoseForm(found.form)->hasTranslation() && node.has(found.translation))
    throw node.error("'" + found.form + "' and '" + found.translation + "'",
                     "only '" + found.form + "', which already contains the whole pose");
  return readKeys(node, found, is_any);
}

// Refuses a notation of another direction than that of its place in the file.
SE3 withFrames(const YamlNode& node, const NamedPose& pose, const std::string& frames) {
  if (pose.frames == "world_from_camera" && frames != pose.frames)
    throw node.error("'transform_matrix', which is world_from_camera", "matrix: 4x4 of this direction");
  return pose.stated;
}

}  // namespace

std::string poseFrames(const std::string& key, bool is_any) {
  if (key == "w2c" || key == "cam_from_world") return "camera_from_world";
  if (key == "c2w" || key == "world_from_cam") return "world_from_camera";
  const std::size_t to = key.find("_to_");
  const std::string frames =
      to == std::string::npos ? key : key.substr(to + 4) + "_from_" + key.substr(0, to);
  const std::size_t from = frames.find("_from_");
  if (from == std::string::npos || is_any) return from == std::string::npos ? "" : frames;
  const std::vector<std::string> ends = {frames.substr(0, from), frames.substr(from + 6)};
  const auto isOther = [](const std::string& end) {
    return end == "world" || end == "board" || end == "rig" || end == "object";
  };
  return std::ranges::count(ends, "camera") == 1 && std::ranges::any_of(ends, isOther) ? frames : "";
}

NamedPose readStatedPose(const YamlNode& node, const std::vector<std::string>& beside, bool is_any) {
  for (const std::string& key : node.isMap() ? node.keys() : std::vector<std::string>()) {
    const std::string frames = isUserKey(key) ? "" : poseFrames(key, is_any);
    if (frames.empty()) continue;
    std::vector<std::string> allowed = beside;
    allowed.push_back(key);
    node.allowKeys(allowed);
    NamedPose pose = node.at(key).isSequence() ? readKeys(node, {.rotation = key, .form = "matrix"}, is_any)
                                               : readUnframed(node.at(key), {}, is_any);
    pose.stated = withFrames(node.at(key), pose, frames);
    pose.frames = frames;
    return pose;
  }
  return readUnframed(node, beside, is_any);
}

SE3 readPose(const YamlNode& node, const std::vector<std::string>& beside) {
  return withFrames(node, readUnframed(node, beside, false), "");
}

void writePose(YAML::Emitter& out, const SE3& pose) {
  flowMap("quaternion_xyzw", quaternionXyzw(pose.rotation), "translation_m", pose.translation)(out);
}

}  // namespace alidade::detail
