// SPDX-License-Identifier: MIT
// Kalibr's camera chain (YAML): the wiki page "Yaml formats" and kalibr_common/ConfigReader.py, which reads
// it. Intrinsics start with the parameters of the projection, followed by the focal lengths: [xi, fu, fv, pu,
// pv] of omni, [alpha, beta, fu, ...] of eucm, [xi, alpha, fu, ...] of ds. Distortion: radtan k1 k2 p1 p2,
// equidistant k1 k2 k3 k4, fov w, none. Pixel (0, 0) is a pixel's centre. OpenVINS reads and writes the same
// keys after %YAML:1.0. The EuRoC data set's cam0/sensor.yaml has one camera at the top level, calls radtan
// radial-tangential and the coefficients distortion_coefficients.
#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade::detail::formats {
namespace kalibr_format {

// camera_model-distortion_model, as on Kalibr's command line; intrinsics and coefficients in one list. The
// first entry of a model is the one that is written.
constexpr std::array<LensLayout, 8> kLenses = {
    {{"pinhole-none", "pinhole", "fx fy cx cy"},
     {"pinhole-radtan", "radtan", "fx fy cx cy k1 k2 p1 p2"},
     {"pinhole-equidistant", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4"},
     {"pinhole-fov", "fov", "fx fy cx cy w"},
     {"omni-radtan", "omni", "xi fx fy cx cy k1 k2 p1 p2"},
     {"omni-none", "omni", "xi fx fy cx cy"},
     {"eucm-none", "eucm", "alpha beta fx fy cx cy"},
     {"ds-none", "double_sphere", "xi alpha fx fy cx cy"}}};

// Poses: of a camera from the previous one, of a camera from the IMU, and of the IMU (EuRoC's body) from a
// camera.
constexpr const char* kChain = "T_cn_cnm1";
constexpr const char* kFromImu = "T_cam_imu";
constexpr std::array kImuFrom = {"T_imu_cam", "T_BS"};
const std::string kPoses = "T_cn_cnm1 T_cam_imu T_imu_cam T_BS ";
const std::string kNotCarried = "timeshift_cam_imu line_delay ";
const std::string kOtherKeys =
    "camera_model intrinsics distortion_model distortion_coeffs distortion_coefficients resolution rostopic "
    "cam_overlaps sensor_type comment rate_hz";

bool isCamera(const YamlNode& node) {
  return node.has("camera_model") && node.has("intrinsics");
}

bool recognises(const CameraDocument& document) {
  if (!document.isMap()) return false;
  if (isCamera(document.root())) return true;
  for (const std::string& key : document.root().keys()) {
    if (key.starts_with("cam") && isCamera(document.root().at(key))) return true;
  }
  return false;
}

// The first part of a lens' name is the camera model, the second the distortion model.
std::string_view cameraModel(const LensLayout& lens) {
  return split(lens.name, '-').front();
}
std::string_view distortionModel(const LensLayout& lens) {
  return split(lens.name, '-').back();
}
std::size_t numIntrinsics(const LensLayout& lens) {
  constexpr std::string_view kLast = "cy";
  return split(lens.order.substr(0, lens.order.find(kLast) + kLast.size()), ' ').size();
}

// "did you mean 'equidistant'?" for "equi" or "equidistand"; otherwise the next step.
std::string adviceFor(const YamlNode& model, const YamlNode& distortion) {
  std::vector<std::string> models;
  std::vector<std::string> distortions;
  for (const LensLayout& lens : kLenses) {
    models.emplace_back(cameraModel(lens));
    distortions.emplace_back(distortionModel(lens));
  }
  for (const auto& [names, node] : {std::pair(models, model), std::pair(distortions, distortion)}) {
    const std::string name = node.text();
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    const auto longer = std::find_if(names.begin(), names.end(), [&name](const std::string& known) {
      return name.size() > 2 && known.starts_with(name);
    });
    const std::string meant = longer != names.end() ? *longer : nearestName(name, names).value_or("");
    if (!meant.empty()) return "did you mean '" + meant + "'?";
  }
  return "calibrate with one of these pairs, in Kalibr or with alidade calibrate";
}

const LensLayout& lensOf(const YamlNode& node) {
  const YamlNode model = node.at("camera_model");
  const YamlNode distortion = node.at("distortion_model");
  const bool is_euroc = distortion.text() == "radial-tangential";
  const std::string name = model.text() + "-" + (is_euroc ? "radtan" : distortion.text());
  if (const LensLayout* lens = findLayout(kLenses, name)) return *lens;
  std::vector<std::string> names;
  for (const LensLayout& lens : kLenses)
    names.push_back(std::string(cameraModel(lens)) + " with " + std::string(distortionModel(lens)));
  throw UnsupportedCamera(
      model.error("'" + model.text() + "' with the distortion_model '" + distortion.text() + "'",
                  join(names, ", "), adviceFor(model, distortion)));
}

// The coefficients' key; Kalibr's if there is none.
std::string coefficientsKey(const YamlNode& node) {
  const std::string of_euroc = "distortion_coefficients";
  if (!node.has(of_euroc)) return "distortion_coeffs";
  if (node.has("distortion_coeffs")) {
    throw node.at(of_euroc).error("'" + of_euroc + "' and 'distortion_coeffs'", "only one of them",
                                  "remove the other");
  }
  return of_euroc;
}

std::vector<StatedNumber> readList(const YamlNode& list, const LensLayout& lens, std::size_t first,
                                   std::size_t count) {
  const std::vector<StatedNumber> numbers = statedNumbers(list);
  if (numbers.size() != count) {
    const std::vector<std::string> names = words(lens.order);
    throw list.error(std::to_string(numbers.size()) + " numbers",
                     std::to_string(count) + " for " + std::string(lens.name) +
                         (count > 0 ? ": " + join(std::span(names).subspan(first, count), " ") : ""),
                     "correct the list, or camera_model and distortion_model");
  }
  return numbers;
}

StatedCamera readOne(const YamlNode& node) {
  const LensLayout& lens = lensOf(node);
  const std::size_t num_intrinsics = numIntrinsics(lens);
  const std::size_t num_all = words(lens.order).size();
  std::vector<StatedNumber> listed = readList(node.at("intrinsics"), lens, 0, num_intrinsics);
  const std::string key = coefficientsKey(node);
  const auto coefficients = node.find(key);
  if (num_all > num_intrinsics || (coefficients && !coefficients->isNull())) {
    append(listed, readList(node.at(key), lens, num_intrinsics, num_all - num_intrinsics));
  }
  std::optional<ImageSize> size;
  if (node.has("resolution")) size = readSize(node.at("resolution"));
  StatedCamera camera =
      stateCamera(node.at("intrinsics").where(), lens.model, storageOrder(lens, listed), size);
  remarkUnknownKeys(node, words(kPoses + kNotCarried + kOtherKeys), camera);
  return camera;
}

// Sorts "cam10" after "cam2", as Kalibr numbers its chain; other names keep their order.
std::vector<std::size_t> chainOrder(const std::vector<std::string>& names) {
  std::vector<std::pair<int, std::size_t>> numbered;
  for (std::size_t i = 0; i < names.size(); ++i)
    numbered.emplace_back(parseInt(names[i].substr(std::min<std::size_t>(names[i].size(), 3))).value_or(0),
                          i);
  std::stable_sort(numbered.begin(), numbered.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  return mapped(numbered, [](const auto& pair) { return pair.second; });
}

bool isStated(const YamlNode& node, const char* key) {
  const auto value = node.find(key);
  return value && !value->isNull();
}

// The pose key to read in these cameras, in chain order; null if no key occurs in all.
const char* poseKey(std::span<const YamlNode> nodes) {
  const auto allHave = [](std::span<const YamlNode> some, const char* key) {
    return !some.empty() &&
           std::all_of(some.begin(), some.end(), [key](const YamlNode& node) { return isStated(node, key); });
  };
  if (allHave(nodes.subspan(1), kChain)) return kChain;
  for (const char* key : {kFromImu, kImuFrom[0], kImuFrom[1]}) {
    if (allHave(nodes, key)) return key;
  }
  return nullptr;
}

// camera_from_rig, with the first camera of a chain, or else the IMU, as the rig's origin.
std::vector<SE3> readPoses(std::span<const YamlNode> nodes, std::string_view key,
                           std::vector<Remark>& remarks) {
  std::vector<SE3> poses;
  for (const YamlNode& node : nodes) {
    if (key != kChain) {
      const SE3 stated = readMotion(node.at(std::string(key)), remarks);
      poses.push_back(key == kFromImu ? stated : stated.inverse());
    } else {
      poses.push_back(poses.empty() ? SE3() : readMotion(node.at(kChain), remarks) * poses.back());
    }
  }
  return poses;
}

// `nodes` are those of the cameras, in the file's order.
void stateKalibrPoses(CameraSource& all, std::span<const YamlNode> nodes,
                      const std::vector<std::string>& names) {
  expect(names.size() == nodes.size(), "each camera has a name, perhaps an empty one");
  const std::vector<std::size_t> order = chainOrder(names);
  const std::vector<YamlNode> chain = mapped(order, [&nodes](std::size_t i) { return nodes[i]; });
  const char* key = poseKey(chain);
  std::vector<std::string> passed = words(kNotCarried);
  for (const std::string& other : words(kPoses)) {
    if (key == nullptr || other != key) passed.push_back(other);
  }
  for (StatedCamera& camera : all.cameras) remarkNotCarried(nodes[camera.number], passed, camera);
  if (key == nullptr) return;
  statePoses(all, [&](std::vector<Remark>& remarks) {
    const std::vector<SE3> in_chain = readPoses(chain, key, remarks);
    std::vector<SE3> poses(in_chain.size());
    for (std::size_t i = 0; i < order.size(); ++i) poses[order[i]] = in_chain[i];
    return poses;
  });
}

CameraSource read(const CameraDocument& document, const ReadOptions&) {
  const YamlNode& root = document.root();
  CameraSource all;
  std::vector<std::string> known;
  std::vector<YamlNode> nodes;
  if (isCamera(root)) {
    all.add("", [&] { return readOne(root); });
    if (all.cameras.empty()) throw UnsupportedCamera(all.refused.front().reason);
    nodes.push_back(root);
  } else {
    for (const std::string& key : root.keys()) {
      if (!key.starts_with("cam")) continue;
      known.push_back(key);
      nodes.push_back(root.at(key));
      all.add(key, [&] { return readOne(root.at(key)); });
    }
    for (StatedCamera& camera : all.cameras) remarkUnknownKeys(root, known, camera);
  }
  if (nodes.empty()) return all;
  stateKalibrPoses(all, nodes, isCamera(root) ? std::vector<std::string>{""} : known);
  return all;
}

// Kalibr has a separate lens for omni without distortion.
const LensLayout& writtenLens(const AnyCamera& camera) {
  const LensLayout& lens = layoutOf(kLenses, camera.modelId());
  const auto lens_parameters = camera.parameters().subspan(4);
  const bool is_plain =
      camera.modelId() == "omni" && std::all_of(lens_parameters.begin() + 1, lens_parameters.end(),
                                                [](double value) { return value == 0; });
  return is_plain ? *findLayout(kLenses, "omni-none") : lens;
}

// As Kalibr writes it, one row per line.
std::string chainText(const SE3& camera_from_last) {
  const Eigen::Matrix4d matrix = camera_from_last.matrix();
  std::string text = std::string("  ") + kChain + ":\n";
  for (Eigen::Index row = 0; row < 4; ++row) text += "  - " + listText(rowMajor(matrix.row(row))) + "\n";
  return text;
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  std::string text;
  const std::vector<SE3> poses = posesOf(cameras);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const LensLayout& lens = writtenLens(cameras[i].camera);
    const std::vector<double> listed = listedOrder(lens, cameras[i].camera);
    const std::span<const double> all(listed);
    const std::size_t num_intrinsics = numIntrinsics(lens);
    // Kalibr identifies cameras by these keys and requires a topic.
    const std::string key = "cam" + std::to_string(i);
    const std::string topic = "/" + (cameras[i].name.empty() ? key : cameras[i].name) + "/image_raw";
    text += key + ":\n";
    if (i > 0 && !poses.empty()) text += chainText(poses[i] * poses[i - 1].inverse());
    text += fmt::format(
        "  cam_overlaps: []\n  camera_model: {}\n  distortion_coeffs: {}\n  distortion_model: {}\n"
        "  intrinsics: {}\n  resolution: [{}, {}]\n  rostopic: {}\n",
        cameraModel(lens), listText(all.subspan(num_intrinsics)), distortionModel(lens),
        listText(all.first(num_intrinsics)), cameras[i].image_size.width, cameras[i].image_size.height,
        yamlText(topic));
  }
  return text;
}

}  // namespace kalibr_format

const CameraFormat& kalibr() {
  using namespace kalibr_format;
  static const CameraFormat kFormat = {
      .id = "kalibr",
      .title = "Kalibr camchain (YAML)",
      .aliases = "camchain kalibr_camchain openvins",
      .models = {"pinhole", "radtan", "kannala_brandt", "fov", "omni", "eucm", "double_sphere"},
      .absent = {{"radtan", "k3"}},
      .max_cameras = CameraFormat::kAnyNumber,
      .poses = CameraFormat::Poses::kFromFirst,
      .marks = {"camera_model", "intrinsics", "distortion_model", "distortion_coeffs"},
      .recognises = recognises,
      .read = read,
      .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
