// SPDX-License-Identifier: MIT
// The rig configuration of COLMAP 3.12 and newer (JSON): a list of rigs, each with cameras: image_prefix;
// ref_sensor: true for the one at the origin, and cam_from_rig_rotation [w, x, y, z] and
// cam_from_rig_translation for the others; camera_model_name and camera_params (COLMAP's documentation, "Rig
// Support", and ReadRigConfig() in colmap/scene/rig.cc). Image sizes are in COLMAP's database only.
#include <algorithm>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/colmap_lenses.h"
#include "alidade/files/formats/pose_numbers.h"
#include "alidade/files/text/file_text.h"

namespace alidade::detail::formats {
namespace colmap_rig_format {

using json = nlohmann::ordered_json;

const std::string kKeys =
    "image_prefix ref_sensor cam_from_rig_rotation cam_from_rig_translation camera_model_name camera_params";

bool recognises(const CameraDocument& document) {
  if (!document.isTree() || !document.root().isSequence()) return false;
  const std::vector<YamlNode> rigs = document.root().items();
  return !rigs.empty() && rigs.front().isMap() && rigs.front().has("cameras");
}

// The last folder of each prefix; whole prefixes if two of these are equal.
std::vector<std::string> namesOf(const std::vector<YamlNode>& cameras) {
  std::vector<std::string> prefixes;
  std::vector<std::string> folders;
  for (const YamlNode& camera : cameras) {
    std::string prefix = camera.at("image_prefix").text();
    while (prefix.ends_with('/')) prefix.pop_back();
    folders.push_back(prefix.substr(prefix.rfind('/') + 1));
    prefixes.push_back(std::move(prefix));
  }
  const bool is_unique = std::set<std::string>(folders.begin(), folders.end()).size() == folders.size();
  return is_unique ? folders : prefixes;
}

StatedCamera readOne(const YamlNode& node, const std::string& name) {
  if (!node.has("camera_model_name") || !node.has("camera_params")) {
    throw node.error("a camera without intrinsics", "camera_model_name and camera_params",
                     "add them: without, COLMAP uses the cameras of its database");
  }
  const LensLayout& lens =
      layoutNamed(kColmapLenses, node.at("camera_model_name"), "run COLMAP with one of these models");
  const YamlNode listed = node.at("camera_params");
  std::vector<StatedNumber> parameters = storageOrder(lens, statedNumbers(listed, words(lens.order).size()));
  takeOrigin(parameters, kColmapOrigin);
  StatedCamera camera = stateCamera(listed.where(), name, lens.model, parameters, std::nullopt);
  remarkUnknownKeys(node, words(kKeys), camera);
  return camera;
}

SE3 readPoseOf(const YamlNode& camera) {
  const YamlNode rotation = camera.at("cam_from_rig_rotation");
  const std::vector<StatedNumber> q = statedNumbers(rotation, 4);
  const SO3 camera_from_rig = withPlace(rotation.where(), [&q] {
    return SO3::fromQuaternion({q[0].value, q[1].value, q[2].value, q[3].value});
  });
  return {camera_from_rig, readVector(camera.at("cam_from_rig_translation"))};
}

// Empty if a pose is left to COLMAP.
std::vector<SE3> readPoses(const YamlNode& rig) {
  std::vector<SE3> poses;
  std::size_t num_references = 0;
  for (const YamlNode& camera : rig.at("cameras").items()) {
    const auto flag = camera.find("ref_sensor");
    const bool is_reference = flag && flag->boolean();
    const bool has_pose = camera.has("cam_from_rig_rotation") && camera.has("cam_from_rig_translation");
    if (is_reference && has_pose)
      throw camera.error("a pose of the reference sensor", "none, because it is the rig's origin");
    if (!is_reference && !has_pose) return {};
    num_references += is_reference ? 1 : 0;
    poses.push_back(is_reference ? SE3() : readPoseOf(camera));
  }
  if (num_references == 1) return poses;
  throw rig.error(std::to_string(num_references) + " cameras with ref_sensor: true", "one");
}

StatedCameras read(const CameraDocument& document, const ReadOptions&) {
  const std::vector<YamlNode> rigs = document.root().items();
  if (rigs.size() != 1) {
    throw document.root().error(std::to_string(rigs.size()) + " rigs", "one",
                                "write each rig to a file of its own");
  }
  const std::vector<YamlNode> cameras = rigs.front().at("cameras").items();
  const std::vector<std::string> names = namesOf(cameras);
  StatedCameras all;
  for (std::size_t i = 0; i < cameras.size(); ++i)
    all.add(names[i], [&] { return readOne(cameras[i], names[i]); });
  for (StatedCamera& camera : all.cameras) remarkUnknownKeys(rigs.front(), {"cameras"}, camera);
  statePoses(all, [&rigs](std::vector<Remark>&) { return readPoses(rigs.front()); });
  return all;
}

std::string write(std::span<const NamedCamera> cameras) {
  const std::vector<SE3> poses = posesFromFirst(cameras);
  json listed = json::array();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const LensLayout& lens = layoutOf(kColmapLenses, cameras[i].camera.modelId());
    const std::string name = cameras[i].name.empty() ? "camera" + std::to_string(i + 1) : cameras[i].name;
    json camera = {{"image_prefix", name + "/"}};
    if (i == 0) camera["ref_sensor"] = true;
    if (i > 0 && !poses.empty()) {
      const SO3::Quaternion& q = poses[i].rotation.quaternion();
      const Eigen::Vector3d& t = poses[i].translation;
      camera["cam_from_rig_rotation"] = {q.w(), q.x(), q.y(), q.z()};
      camera["cam_from_rig_translation"] = {t.x(), t.y(), t.z()};
    }
    camera["camera_model_name"] = lens.name;
    camera["camera_params"] = listedOrder(lens, cameras[i].camera, kColmapOrigin);
    listed.push_back(std::move(camera));
  }
  return json::array({{{"cameras", std::move(listed)}}}).dump(2) + "\n";
}

}  // namespace colmap_rig_format

const CameraFormat& colmapRig() {
  using namespace colmap_rig_format;
  static const CameraFormat kFormat = {
      .id = "colmap_rig",
      .title = "COLMAP rig configuration (JSON)",
      .models = {"pinhole", "radtan", "rational", "kannala_brandt", "fov", "eucm"},
      .absent = {{"radtan", "k3"}},
      .max_cameras = CameraFormat::kAnyNumber,
      .poses = CameraFormat::Poses::kFromFirst,
      .holds_size = false,
      .marks = {"image_prefix", "camera_model_name", "camera_params"},
      .recognises = recognises,
      .read = read,
      .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
