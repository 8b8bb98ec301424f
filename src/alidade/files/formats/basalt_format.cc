// SPDX-License-Identifier: MIT
// basalt's calibration (JSON, by cereal): value0 with intrinsics (camera_type and its parameters by name) and
// resolution, and T_imu_cam, the pose of each camera in the IMU's frame (basalt-headers:
// serialization/headers_serialization.h; the names of the types in camera/*.hpp; pinhole-radtan8 in the forks
// of Monado). Pixel (0, 0) is a pixel's centre.
#include <array>
#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade::detail::formats {
namespace basalt_format {

using json = nlohmann::ordered_json;

constexpr std::array<LensLayout, 7> kLenses = {
    {{"pinhole", "pinhole", "fx fy cx cy"},
     {"pinhole-radtan8", "rational", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"},
     {"kb4", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4"},
     {"fov", "fov", "fx fy cx cy w"},
     {"ucm", "ucm", "fx fy cx cy alpha"},
     {"eucm", "eucm", "fx fy cx cy alpha beta"},
     {"ds", "double_sphere", "fx fy cx cy xi alpha"}}};

const std::string kNotCarried =
    "vignette calib_accel_bias calib_gyro_bias cam_time_offset_ns T_mocap_world T_imu_marker view_offset";
const std::string kOtherKeys =
    " T_imu_cam intrinsics resolution imu_update_rate accel_noise_std gyro_noise_std accel_bias_std "
    "gyro_bias_std mocap_time_offset_ns mocap_to_imu_offset_ns";

bool recognises(const CameraDocument& document) {
  if (!document.has("value0")) return false;
  const YamlNode value = document.root().at("value0");
  return value.has("intrinsics") && value.has("resolution");
}

// Remarks on the radius on the normalised plane beyond which basalt projects nothing; 0 is no limit. Alidade
// computes the limit of the lens itself, so only a narrower one is reported.
void remarkLimit(const YamlNode& parameters, StatedCamera& camera) {
  const auto node = parameters.find("rpmax");
  if (!node) return;
  const double limit = node->number();
  constexpr double kRounding = 1e-6;
  if (limit == 0 || limit > std::tan(camera.camera.cone().max_angle_rad) * (1 - kRounding)) return;
  camera.remarks.push_back(
      {"not_carried", node->where() + ": the limit of " + node->text() +
                          " on the normalised plane is narrower than the domain of the lens; it is ignored"});
}

SE3 readPoseOf(const YamlNode& node) {
  const auto at = [&node](const char* key) { return node.at(key).number(); };
  const SO3::Quaternion q(at("qw"), at("qx"), at("qy"), at("qz"));
  const SO3 rotation = withPlace(node.where(), [&q] { return SO3::fromQuaternion(q); });
  return {rotation, {at("px"), at("py"), at("pz")}};
}

// The IMU is the rig's origin. Files of single cameras have identity poses, which mean nothing.
std::vector<SE3> readPoses(const YamlNode& value, std::size_t num_cameras) {
  const auto listed = value.find("T_imu_cam");
  if (!listed || listed->isNull()) return {};
  std::vector<SE3> poses;
  bool says_nothing = true;
  for (const YamlNode& item : listed->items()) {
    const SE3 imu_from_camera = readPoseOf(item);
    says_nothing = says_nothing && imu_from_camera.log().isZero(0);
    poses.push_back(imu_from_camera.inverse());
  }
  if (poses.size() != num_cameras) {
    throw listed->error(std::to_string(poses.size()) + " poses",
                        std::to_string(num_cameras) + ", one per camera",
                        "add the missing ones, or remove the extra ones");
  }
  return says_nothing ? std::vector<SE3>() : poses;
}

StatedCamera readOne(const YamlNode& node, const YamlNode& resolution) {
  const LensLayout lens =
      layoutNamed(kLenses, node.at("camera_type"),
                  "calibrate with one of these types, or remove the camera from the file");
  std::vector<std::string> keys = words(lens.order);
  const YamlNode parameters = node.at("intrinsics");
  StatedCamera camera = stateCamera(parameters.where(), lens.model,
                                    storageOrder(lens, numbersOf(parameters, keys)), readSize(resolution));
  if (camera.camera.modelId() == "rational") {
    keys.emplace_back("rpmax");
    remarkLimit(parameters, camera);
  }
  remarkUnknownKeys(parameters, keys, camera);
  remarkUnknownKeys(node, {"camera_type", "intrinsics"}, camera);
  return camera;
}

CameraSource read(const CameraDocument& document, const ReadOptions&) {
  const YamlNode value = document.root().at("value0");
  const std::vector<YamlNode> intrinsics = value.at("intrinsics").items();
  const std::vector<YamlNode> resolutions = value.at("resolution").items();
  if (intrinsics.size() != resolutions.size()) {
    throw value.at("resolution")
        .error(std::to_string(resolutions.size()) + " sizes",
               std::to_string(intrinsics.size()) + ", one per camera",
               "add the missing ones, or remove the extra ones");
  }
  CameraSource all;
  for (std::size_t i = 0; i < intrinsics.size(); ++i) {
    all.add("cam" + std::to_string(i), [&] { return readOne(intrinsics[i], resolutions[i]); });
  }
  for (StatedCamera& camera : all.cameras) {
    remarkUnknownKeys(value, words(kNotCarried + kOtherKeys), camera);
    remarkNotCarried(value, words(kNotCarried), camera);
  }
  statePoses(all, [&](std::vector<Remark>&) { return readPoses(value, intrinsics.size()); });
  return all;
}

json intrinsicsJson(const AnyCamera& camera) {
  const LensLayout& lens = layoutOf(kLenses, camera.modelId());
  const std::vector<std::string> names = words(lens.order);
  const std::vector<double> values = listedOrder(lens, camera);
  json numbers = json::object();
  for (std::size_t i = 0; i < names.size(); ++i) numbers[names[i]] = values[i];
  if (camera.modelId() == "rational") numbers["rpmax"] = std::tan(camera.cone().max_angle_rad);
  return {{"camera_type", lens.name}, {"intrinsics", std::move(numbers)}};
}

json poseJson(const NamedCamera& named) {
  const SE3 imu_from_camera = named.camera_from_rig.value_or(SE3()).inverse();
  const Eigen::Vector3d& p = imu_from_camera.translation;
  const SO3::Quaternion& q = imu_from_camera.rotation.quaternion();
  return {{"px", p.x()}, {"py", p.y()}, {"pz", p.z()}, {"qx", q.x()},
          {"qy", q.y()}, {"qz", q.z()}, {"qw", q.w()}};
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  const auto intrinsics = [](const NamedCamera& named) { return intrinsicsJson(named.camera); };
  const auto size = [](const NamedCamera& n) { return std::array{n.image_size.width, n.image_size.height}; };
  // basalt requires the remaining keys. These values are those that its own camera calibration writes before
  // the IMU is calibrated.
  const json values = {{"T_imu_cam", mapped(cameras, poseJson)},
                       {"intrinsics", mapped(cameras, intrinsics)},
                       {"resolution", mapped(cameras, size)},
                       {"calib_accel_bias", std::vector<double>(9)},
                       {"calib_gyro_bias", std::vector<double>(12)},
                       {"imu_update_rate", 200.0},
                       {"accel_noise_std", {0.016, 0.016, 0.016}},
                       {"gyro_noise_std", {0.000282, 0.000282, 0.000282}},
                       {"accel_bias_std", {0.001, 0.001, 0.001}},
                       {"gyro_bias_std", {0.0001, 0.0001, 0.0001}},
                       {"cam_time_offset_ns", 0},
                       {"vignette", json::array()}};
  return json({{"value0", values}}).dump(2) + "\n";
}

}  // namespace basalt_format

const CameraFormat& basalt() {
  using namespace basalt_format;
  static const CameraFormat kFormat = {
      .id = "basalt",
      .title = "basalt calibration (JSON)",
      .models = {"pinhole", "rational", "kannala_brandt", "fov", "ucm", "eucm", "double_sphere"},
      .max_cameras = CameraFormat::kAnyNumber,
      .poses = CameraFormat::Poses::kFromRig,
      .marks = {"camera_type", "intrinsics"},
      .recognises = recognises,
      .read = read,
      .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
