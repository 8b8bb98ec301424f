// SPDX-License-Identifier: MIT
// COLMAP's cameras.txt: one line per camera, ID MODEL WIDTH HEIGHT PARAMS (COLMAP's
// documentation, "Output format"; names and orders of the parameters in colmap/sensor/models.h). COLMAP
// counts pixels from the image's corner: the centre of the first one is (0.5, 0.5).
//
// The rig configuration of COLMAP 3.12 and newer (JSON): a list of rigs, each with cameras: image_prefix;
// ref_sensor: true for the one at the origin, and cam_from_rig_rotation [w, x, y, z] and
// cam_from_rig_translation for the others; camera_model_name and camera_params (COLMAP's documentation, "Rig
// Support", and ReadRigConfig() in colmap/scene/rig.cc). Image sizes are in COLMAP's database only.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade::detail::formats {
namespace colmap_format {

using json = nlohmann::ordered_json;

constexpr double kOrigin = 0.5;  // px, of the first pixel's centre

constexpr std::array<LensLayout, 18> kNumbered = {
    {{"SIMPLE_PINHOLE", "pinhole", "f cx cy"},
     {"PINHOLE", "pinhole", "fx fy cx cy"},
     {"SIMPLE_RADIAL", "radtan", "f cx cy k1"},
     {"RADIAL", "radtan", "f cx cy k1 k2"},
     {"OPENCV", "radtan", "fx fy cx cy k1 k2 p1 p2"},
     {"OPENCV_FISHEYE", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4"},
     {"FULL_OPENCV", "rational", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"},
     {"FOV", "fov", "fx fy cx cy w"},
     {"SIMPLE_RADIAL_FISHEYE", "kannala_brandt", "f cx cy k1"},
     {"RADIAL_FISHEYE", "kannala_brandt", "f cx cy k1 k2"},
     {"THIN_PRISM_FISHEYE", "thin_prism_fisheye", "fx fy cx cy k1 k2 p1 p2 k3 k4 s1 s2"},
     {"RAD_TAN_THIN_PRISM_FISHEYE", "fisheye624", "fx fy cx cy k0 k1 k2 k3 k4 k5 p0 p1 s0 s1 s2 s3"},
     {"SIMPLE_DIVISION", "division", "f cx cy k1"},
     {"DIVISION", "division", "fx fy cx cy k1"},
     {"SIMPLE_FISHEYE", "kannala_brandt", "f cx cy"},
     {"FISHEYE", "kannala_brandt", "fx fy cx cy"},
     {"EUCM", "eucm", "fx fy cx cy alpha beta"},
     {"EQUIRECTANGULAR", "", "cx cy"}}};
constexpr std::span kLenses(kNumbered.data(), kNumbered.size() - 1);  // that are supported

const std::vector<std::string_view> kModels = {"pinhole",   "radtan", "rational", "kannala_brandt",
                                               "fov",       "eucm",   "division", "thin_prism_fisheye",
                                               "fisheye624"};

struct Line {
  std::string place;  // "cameras.txt:4"
  std::vector<std::string> words;
};

// All lines except comments and empty ones, up to `max_count`.
std::vector<Line> linesOf(const CameraDocument& document, std::size_t max_count) {
  std::vector<Line> lines;
  std::size_t number = 0;
  for (const std::string_view text : split(document.text(), '\n')) {
    ++number;
    std::vector<std::string> fields = words(text);
    if (fields.empty() || fields.front().starts_with('#')) continue;
    lines.push_back({document.file() + ":" + std::to_string(number), std::move(fields)});
    if (lines.size() == max_count) break;
  }
  return lines;
}

bool isModelName(std::string_view word) {
  return word.size() > 2 &&
         std::all_of(word.begin(), word.end(),
                     [](char c) { return c == '_' || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }) &&
         word.front() >= 'A';
}

bool recognises(const CameraDocument& document) {
  if (document.isMap()) return false;
  const std::vector<Line> lines = linesOf(document, 1);
  if (lines.empty())
    return document.text().find("# Camera list with one line of data per camera") != std::string::npos;
  const std::vector<std::string>& words = lines.front().words;
  return words.size() > 4 && parseInt(words[0]) && isModelName(words[1]) && parseDouble(words[2]) &&
         parseDouble(words[3]);
}

int sideOf(const Line& line, const std::string& word) {
  constexpr int kMaxSide = 1'000'000;
  const auto side = parseInt(word);
  if (side && *side >= 1 && *side <= kMaxSide) return *side;
  throw errorAt(line.place, "found '" + word + "'", "a whole number of pixels, 1 to 1000000",
                "use the size of the image files");
}

// The camera of a line. If it is not wanted, only checks it and returns nothing, because making it takes
// milliseconds.
std::optional<StatedCamera> readLine(const Line& line, bool is_wanted) {
  constexpr std::size_t kNumBefore = 4;
  if (line.words.size() <= kNumBefore) {
    throw errorAt(line.place, "found " + std::to_string(line.words.size()) + " words",
                  "ID MODEL WIDTH HEIGHT PARAMS", "complete the line, or remove it");
  }
  if (!parseInt(line.words[0])) {
    throw errorAt(line.place, "found '" + line.words[0] + "'", "a camera number",
                  "start the line with a camera number, or remove it");
  }
  const LensLayout* lens = findLayout(kLenses, line.words[1]);
  if (lens == nullptr) {
    throw UnsupportedCamera(errorAt(
        line.place, "found the camera model " + line.words[1], "one of " + join(layoutNames(kLenses), ", "),
        "run COLMAP with one of these models, or remove the camera from the file"));
  }
  const std::vector<std::string> names = words(lens->order);
  if (line.words.size() != kNumBefore + names.size()) {
    throw errorAt(line.place, "found " + std::to_string(line.words.size() - kNumBefore) + " parameters",
                  std::to_string(names.size()) + " for " + std::string(lens->name) + ": " + join(names, " "),
                  "correct the model, or write all of its parameters");
  }
  std::vector<StatedNumber> listed;
  for (std::size_t i = kNumBefore; i < line.words.size(); ++i) {
    const auto number = parseDouble(line.words[i]);
    if (!number || !std::isfinite(*number)) {
      throw errorAt(line.place, "found '" + line.words[i] + "'",
                    "a finite number for " + names[i - kNumBefore],
                    "correct it, or remove the camera from the file");
    }
    listed.push_back({*number});
  }
  std::vector<StatedNumber> parameters = storageOrder(*lens, listed);
  takeOrigin(parameters, kOrigin);
  const ImageSize size = {.width = sideOf(line, line.words[2]), .height = sideOf(line, line.words[3])};
  bool is_valid = true;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    is_valid = is_valid && !parameterComplaint(lens->model, i, parameters[i].value);
  if (is_valid && !is_wanted) return std::nullopt;
  return stateCamera(line.place, lens->model, parameters, size);  // throws if they are invalid
}

// Compares with the count in the comment "# Number of cameras: 2".
void remarkOtherCount(const CameraDocument& document, std::size_t num_cameras, StatedCamera& camera) {
  constexpr std::string_view kStart = "# Number of cameras:";
  std::size_t number = 0;
  for (const std::string_view line : split(document.text(), '\n')) {
    ++number;
    if (!line.starts_with(kStart)) continue;
    const std::string_view rest = trim(line.substr(kStart.size()));
    const auto count = parseInt(rest.substr(0, rest.find_first_of(", \t")));
    if (!count || *count == static_cast<int>(num_cameras)) return;
    camera.remarks.push_back(
        {"assumed", fmt::format("{}:{}: the header states {} cameras, but the file contains {}; it was read, "
                                "but it may be truncated",
                                document.file(), number, *count, num_cameras)});
    return;
  }
}

CameraSource read(const CameraDocument& document, const ReadOptions& options) {
  constexpr std::size_t kMaxCameras = 100'000;
  CameraSource all;
  const std::vector<Line> lines = linesOf(document, kMaxCameras + 1);
  if (lines.empty()) {
    throw errorAt(document.file(), "found only comments",
                  "a line ID MODEL WIDTH HEIGHT PARAMS for each camera",
                  "export the model again: colmap model_converter --output_type TXT");
  }
  if (lines.size() > kMaxCameras) {
    throw errorAt(lines.back().place, "found more than " + std::to_string(kMaxCameras) + " cameras", "fewer",
                  "split the file");
  }
  for (const Line& line : lines) {
    const std::string& name = line.words[0];
    if (options.only.empty() || name == options.only) {
      all.add(name, [&line] { return *readLine(line, true); });
      continue;
    }
    try {
      static_cast<void>(readLine(line, false));
    } catch (const UnsupportedCamera&) {
      // Unsupported, but not damaged.
    }
    all.passed.push_back(name);
  }
  // Applies to the whole file, so it is stated once.
  if (!all.cameras.empty()) remarkOtherCount(document, lines.size(), all.cameras.front());
  return all;
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  std::string text = fmt::format(
      "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
      "# Number of cameras: {}\n",
      cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const LensLayout& lens = layoutOf(kLenses, cameras[i].camera.modelId());
    text += fmt::format("{} {} {} {}", i + 1, lens.name, cameras[i].image_size.width,
                        cameras[i].image_size.height);
    for (const double value : listedOrder(lens, cameras[i].camera, kOrigin)) text += " " + exactText(value);
    text += "\n";
  }
  return text;
}

const std::string kRigKeys =
    "image_prefix ref_sensor cam_from_rig_rotation cam_from_rig_translation camera_model_name camera_params";

bool recognisesRig(const CameraDocument& document) {
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

StatedCamera readOne(const YamlNode& node) {
  if (!node.has("camera_model_name") || !node.has("camera_params")) {
    throw node.error("a camera without intrinsics", "camera_model_name and camera_params",
                     "add them: without, COLMAP uses the cameras of its database");
  }
  const LensLayout lens =
      layoutNamed(kLenses, node.at("camera_model_name"), "run COLMAP with one of these models");
  const YamlNode listed = node.at("camera_params");
  std::vector<StatedNumber> parameters = storageOrder(lens, statedNumbers(listed, words(lens.order).size()));
  takeOrigin(parameters, kOrigin);
  StatedCamera camera = stateCamera(listed.where(), lens.model, parameters, std::nullopt);
  remarkUnknownKeys(node, words(kRigKeys), camera);
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

CameraSource readRig(const CameraDocument& document, const ReadOptions&) {
  const std::vector<YamlNode> rigs = document.root().items();
  if (rigs.size() != 1) {
    throw document.root().error(std::to_string(rigs.size()) + " rigs", "one",
                                "write each rig to a file of its own");
  }
  const std::vector<YamlNode> cameras = rigs.front().at("cameras").items();
  const std::vector<std::string> names = namesOf(cameras);
  CameraSource all;
  for (std::size_t i = 0; i < cameras.size(); ++i) all.add(names[i], [&] { return readOne(cameras[i]); });
  for (StatedCamera& camera : all.cameras) remarkUnknownKeys(rigs.front(), {"cameras"}, camera);
  statePoses(all, [&rigs](std::vector<Remark>&) { return readPoses(rigs.front()); });
  return all;
}

std::string writeRig(std::span<const NamedCamera> cameras, const std::string&) {
  const std::vector<SE3> poses = posesFromFirst(cameras);
  json listed = json::array();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const LensLayout& lens = layoutOf(kLenses, cameras[i].camera.modelId());
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
    camera["camera_params"] = listedOrder(lens, cameras[i].camera, kOrigin);
    listed.push_back(std::move(camera));
  }
  return json::array({{{"cameras", std::move(listed)}}}).dump(2) + "\n";
}

}  // namespace colmap_format

const CameraFormat& colmap() {
  using namespace colmap_format;
  static const CameraFormat kFormat = {.id = "colmap",
                                       .title = "COLMAP cameras.txt",
                                       .models = kModels,
                                       .absent = {{"radtan", "k3"}, {"division", "k2"}},
                                       .max_cameras = CameraFormat::kAnyNumber,
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

const CameraFormat& colmapRig() {
  using namespace colmap_format;
  static const CameraFormat kFormat = {.id = "colmap_rig",
                                       .title = "COLMAP rig configuration (JSON)",
                                       .models = kModels,
                                       .absent = {{"radtan", "k3"}, {"division", "k2"}},
                                       .max_cameras = CameraFormat::kAnyNumber,
                                       .poses = CameraFormat::Poses::kFromFirst,
                                       .holds_size = false,
                                       .marks = {"image_prefix", "camera_model_name", "camera_params"},
                                       .recognises = recognisesRig,
                                       .read = readRig,
                                       .write = writeRig};
  return kFormat;
}

}  // namespace alidade::detail::formats

std::span<const alidade::detail::LensLayout> alidade::detail::colmapLenses() {
  return formats::colmap_format::kNumbered;
}
