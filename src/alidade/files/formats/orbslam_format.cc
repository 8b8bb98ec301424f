// SPDX-License-Identifier: MIT
// ORB-SLAM3's settings (OpenCV's YAML; src/Settings.cc): Camera.type, Camera.width, Camera.height, and keys
// Camera1.fx ... of the first camera, Camera2.fx ... of the second. Files without File.version, and those of
// ORB-SLAM2, name the first camera's keys Camera.fx ... PinHole has k1 k2 p1 p2 [k3], KannalaBrandt8 k1 k2 k3
// k4. Pixel (0, 0) is a pixel's centre. OpenVSLAM and stella_vslam (camera/perspective.cc, camera/fisheye.cc)
// use the same keys, but Camera.model instead of the type and Camera.cols and Camera.rows for the size;
// stella_vslam puts them into a map Camera.
#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade::detail::formats {
namespace orbslam_format {

constexpr LensLayout kPlain = {"PinHole", "pinhole", "fx fy cx cy"};
constexpr LensLayout kRadtan = {"PinHole", "radtan", "fx fy cx cy k1 k2 p1 p2"};
constexpr LensLayout kRadtan5 = {"PinHole", "radtan", "fx fy cx cy k1 k2 p1 p2 k3"};
constexpr LensLayout kFisheye = {"KannalaBrandt8", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4"};
constexpr std::array<LensLayout, 3> kWritten = {kPlain, kRadtan5, kFisheye};

const std::string kNumbers = "fx fy cx cy k1 k2 k3 k4 k5 k6 p1 p2 ";
const std::string kOtherCameraKeys =
    "type width height fps RGB bf newWidth newHeight imageScale overlappingBegin overlappingEnd lappingBegin "
    "lappingEnd name setup model cols rows color_order focal_x_baseline depth_threshold";
const std::string kTransforms =
    "Tbc IMU.T_b_c1 Camera.newWidth Camera.newHeight Camera.imageScale LEFT.R RIGHT.R";
// Camera matrices of the original images in files whose cameras refer to rectified ones.
const std::string kRawMatrices =
    "LEFT.K RIGHT.K StereoRectifier StereoRectifier.K_left StereoRectifier.K_right";
// Prefixes of settings that do not concern the camera.
const std::string kOtherSettings =
    "File. ORBextractor. Viewer. IMU. Stereo. RGBD. System. LEFT. RIGHT. ThDepth DepthMapFactor thFarPoints "
    "Tbc loopClosing Initializer. Feature. StereoRectifier PangolinViewer. Mapping. Tracking. "
    "depthmap_factor";

// The keys of a camera: "Camera1.fx" of the file, or "fx" of a map.
struct Keys {
  YamlNode map;
  std::string prefix;

  [[nodiscard]] std::string of(std::string_view name) const { return prefix + std::string(name); }
  [[nodiscard]] std::optional<YamlNode> find(std::string_view name) const { return map.find(of(name)); }
  [[nodiscard]] bool has(std::string_view name) const { return map.has(of(name)); }
};

bool isNested(const YamlNode& root) {
  const auto camera = root.find("Camera");
  return camera && camera->isMap() && camera->has("model");
}

bool recognises(const CameraDocument& document) {
  return document.has("Camera.type") || document.has("Camera.fx") || document.has("Camera1.fx") ||
         document.has("Camera.model") || (document.isMap() && isNested(document.root()));
}

// Alidade's model for OpenVSLAM's Camera.model; empty if there is none.
std::string typeOfModel(const Keys& common) {
  const auto model = common.find("model");
  if (!model) return "";
  if (model->text() == "perspective") return "PinHole";
  if (model->text() == "fisheye") return "KannalaBrandt8";
  throw UnsupportedCamera(
      model->error("'" + model->text() + "'", "perspective or fisheye",
                   "convert the images to one of these projections, and calibrate again"));
}

// Empty if the file does not state it.
std::string typeOf(const Keys& common) {
  const std::string of_model = typeOfModel(common);
  const auto type = common.find("type");
  if (!type) return of_model;
  const std::vector<std::string> known = {"PinHole", "Rectified", "KannalaBrandt8"};
  if (std::find(known.begin(), known.end(), type->text()) == known.end()) {
    throw UnsupportedCamera(type->error(
        "'" + type->text() + "'", join(known, ", "),
        didYouMean(type->text(), known, "use another lens model in the program that wrote the file")));
  }
  if (!of_model.empty() && of_model != type->text()) {
    throw type->error(
        "'" + type->text() + "' and " + common.of("model") + " '" + common.find("model")->text() + "'",
        "values that agree", "remove the wrong one");
  }
  return type->text();
}

const LensLayout& lensOf(const Keys& keys, const std::string& type) {
  if (type == "KannalaBrandt8") return kFisheye;
  if (type == "Rectified") return kPlain;
  if (keys.has("k3")) return kRadtan5;
  for (const char* name : {"k1", "k2", "p1", "p2"}) {
    if (keys.has(name)) return kRadtan;
  }
  return kPlain;
}

// "write Camera.type: KannalaBrandt8"
std::string adviceForFisheye(const Keys& common) {
  return common.has("model") && !common.has("type") ? "write " + common.of("model") + ": fisheye"
                                                    : "write " + common.of("type") + ": KannalaBrandt8";
}

// A file without a type is from ORB-SLAM2, which has no fisheye, but k1 to k4 without other coefficients
// indicate one. A k4 of 0 counts as missing.
void refuseFisheyeWithoutType(const Keys& keys, const Keys& common) {
  const auto k4 = keys.find("k4");
  if (!k4 || keys.has("p1") || keys.has("p2") || statedNumber(*k4).value == 0) return;
  throw k4->error("coefficients k1 to k4 but no " + common.of("type"),
                  "a fisheye type, or k1 k2 p1 p2 of an ordinary lens",
                  "if it is a fisheye, " + adviceForFisheye(common));
}

// A coefficient that the lens does not have would be lost. A value of 0 counts as missing.
void refuseForeignCoefficients(const Keys& keys, const Keys& common, const LensLayout& lens,
                               const std::string& type) {
  const std::vector<std::string> own = words(lens.order);
  for (const std::string& name : words(kNumbers)) {
    const auto node = keys.find(name);
    if (!node || std::find(own.begin(), own.end(), name) != own.end()) continue;
    if (statedNumber(*node).value == 0) continue;
    const std::string found = "'" + node->text() + "'";
    if (type == "KannalaBrandt8") {
      throw node->error(found,
                        "0 or no such key, because a fisheye has k1 k2 k3 k4; p1 and p2 belong to PinHole",
                        "correct the type, or use coefficients from a calibration of this type");
    }
    if (type == "Rectified") {
      throw node->error(found, "0 or no such key, because Rectified images have no distortion",
                        "remove the coefficients, or write PinHole if they describe the images");
    }
    throw node->error(found, "0 or no such key, because an ordinary lens has k1 k2 p1 p2 k3",
                      "if it is a fisheye, " + adviceForFisheye(common) +
                          "; otherwise calibrate with only these coefficients");
  }
}

std::optional<ImageSize> sizeOf(const Keys& common, const ReadOptions& options,
                                std::vector<Remark>& remarks) {
  const auto sides = [&](const char* width, const char* height) {
    return sizeOfSides({common.map}, common.of(width), common.of(height), options.image_size, remarks);
  };
  const auto size = sides("width", "height");
  const auto other = sides("cols", "rows");
  if (size && other && *size != *other) {
    throw common.find("cols")
        .value_or(common.map)
        .error("an image size that differs from " + common.of("width") + " and " + common.of("height"),
               "values that agree", "remove the wrong one");
  }
  return size ? size : other;
}

StatedCamera readOne(const Keys& keys, const Keys& common, const ReadOptions& options) {
  const std::string type = typeOf(common);
  if (type.empty()) refuseFisheyeWithoutType(keys, common);
  const LensLayout& lens = lensOf(keys, type);
  refuseForeignCoefficients(keys, common, lens, type);
  const auto names = mapped(words(lens.order), [&](const std::string& listed) { return keys.of(listed); });
  std::vector<Remark> remarks;
  const auto size = sizeOf(common, options, remarks);
  StatedCamera camera = stateCamera(keys.map.at(names.front()).where(), lens.model,
                                    storageOrder(lens, numbersOf(keys.map, names)), size, remarks);
  if (type.empty()) {
    camera.remarks.push_back({"assumed", common.map.where() + ": there is no " + common.of("type") +
                                             "; assumed to be PinHole, as in ORB-SLAM2"});
  }
  return camera;
}

bool isOfCamera(const std::string& key) {
  const std::size_t dot = key.find('.');
  const std::string prefix = key.substr(0, dot);
  if (dot == std::string::npos || (prefix != "Camera" && prefix != "Camera1" && prefix != "Camera2"))
    return false;
  const std::vector<std::string> known = words(kNumbers + kOtherCameraKeys);
  return std::find(known.begin(), known.end(), key.substr(dot + 1)) != known.end();
}

std::vector<std::string> knownKeys(const YamlNode& root) {
  const std::vector<std::string> settings = words(kOtherSettings);
  std::vector<std::string> known;
  for (const std::string& key : root.keys()) {
    const bool is_setting = std::any_of(settings.begin(), settings.end(),
                                        [&key](const std::string& start) { return key.starts_with(start); });
    if (is_setting || isOfCamera(key)) known.push_back(key);
  }
  return known;
}

// ORB-SLAM2's settings of a pair: it rectifies the images of these two cameras, of which the file states the
// camera matrix, coefficients of cv::projectPoints, and how they are rectified.
constexpr std::array kRawPair = {"LEFT.", "RIGHT."};

StatedCamera readRaw(const Keys& keys) {
  const YamlNode matrix = keys.map.at(keys.of("K"));
  std::vector<StatedNumber> parameters = readCameraMatrix(matrix);
  std::vector<StatedNumber> coefficients = statedNumbers(keys.map.at(keys.of("D")));
  const std::string_view model = modelOfCoefficients(keys.map.at(keys.of("D")), coefficients);
  append(parameters, coefficients);
  return stateCamera(matrix.where(), model, parameters,
                     readSize(keys.map.at(keys.of("width")), keys.map.at(keys.of("height"))));
}

CameraSource readRawPair(const YamlNode& root) {
  CameraSource all;
  for (const std::string side : kRawPair)
    all.add(side.substr(0, side.size() - 1), [&] { return readRaw({root, side}); });
  statePoses(all, [&root](std::vector<Remark>& remarks) {
    std::vector<SE3> poses;
    for (const std::string side : kRawPair) {
      if (const auto pose = readRectification(root, side + "R", side + "P", remarks)) poses.push_back(*pose);
    }
    return poses.size() == kRawPair.size() ? poses : std::vector<SE3>();
  });
  for (StatedCamera& camera : all.cameras) {
    remarkUnknownKeys(root, knownKeys(root), camera);
    camera.remarks.push_back(
        {"not_carried",
         root.whereKey("Camera.fx") +
             ": this camera belongs to the rectified images, and those that were read to the original "
             "ones; select it with FILE#Camera1"});
  }
  return all;
}

// The second camera of a rectified pair, whose baseline is Camera.bf divided by fx.
void addRectifiedSecond(const YamlNode& root, CameraSource& all) {
  const auto bf = root.find("Camera.bf");
  if (!bf || all.cameras.size() != 1) return;
  StatedCamera second = all.cameras.front();
  second.remarks.clear();
  all.add("Camera2", [&second] { return second; });
  statePoses(all, [&](std::vector<Remark>&) {
    const double baseline_m = bf->number() / second.camera.parameter("fx");
    return std::vector<SE3>{SE3(), SE3(SO3(), Eigen::Vector3d(-baseline_m, 0, 0))};
  });
}

// A pair's file also has the cameras of the images before rectification.
void remarkRawCameras(const YamlNode& root, StatedCamera& camera) {
  for (const std::string& key : words(kRawMatrices)) {
    if (!root.has(key)) continue;
    camera.remarks.push_back(
        {"not_carried", root.whereKey(key) + ": this camera belongs to the original images and is ignored; "
                                             "the camera that was read belongs to the rectified images"});
    return;
  }
}

// The first camera has two sets of names, of which ORB-SLAM reads one. Both must agree; a coefficient of 0
// counts as missing.
void refuseMixedNames(const YamlNode& root, const std::string& own, const std::string& other) {
  for (const std::string& name : words(kNumbers)) {
    const auto ours = root.find(own + "." + name);
    const auto theirs = root.find(other + "." + name);
    if (!theirs) continue;
    const StatedNumber number = statedNumber(*theirs);
    if (ours && statedNumber(*ours).value == number.value) continue;
    if (ours) {
      throw theirs->error("'" + theirs->text() + "' where " + ours->where() + " says '" + ours->text() + "'",
                          "one set of keys for the first camera, or equal values", "remove the wrong one");
    }
    if (number.value == 0) continue;
    throw theirs->error("'" + other + "." + name + "' without '" + own + "." + name + "', in addition to " +
                            root.at(own + ".fx").where(),
                        "one set of keys for the first camera",
                        "rename it, or remove it if it is something else");
  }
}

// stella_vslam's map of one camera; its other maps are settings.
CameraSource readNested(const YamlNode& root, const ReadOptions& options) {
  const YamlNode camera_map = root.at("Camera");
  const Keys keys = {camera_map, ""};
  StatedCamera camera = readOne(keys, keys, options);
  remarkUnknownKeys(camera_map, words(kNumbers + kOtherCameraKeys), camera);
  remarkRawCameras(root, camera);
  return {.cameras = {camera}};
}

CameraSource read(const CameraDocument& document, const ReadOptions& options) {
  const YamlNode& root = document.root();
  if (isNested(root)) return readNested(root, options);
  const bool is_raw_pair = root.has("LEFT.K") && root.has("RIGHT.K") && root.has("Camera.fx");
  if (is_raw_pair && options.only != "Camera1" && options.only != "Camera2") return readRawPair(root);
  CameraSource all;
  const Keys common = {root, "Camera."};
  const bool is_older = !root.has("Camera1.fx") && (root.has("Camera.fx") || root.has("Camera.model"));
  if (root.has("Camera1.fx") || root.has("Camera.fx"))
    refuseMixedNames(root, is_older ? "Camera" : "Camera1", is_older ? "Camera1" : "Camera");
  const Keys first = {root, is_older ? "Camera." : "Camera1."};
  all.add("Camera1", [&] { return readOne(first, common, options); });
  if (root.has("Camera2.fx"))
    all.add("Camera2", [&] { return readOne({root, "Camera2."}, common, options); });
  if (is_raw_pair) addRectifiedSecond(root, all);
  const bool is_stereo = root.has("Stereo.T_c1_c2") && all.cameras.size() + all.refused.size() == 2;
  if (is_stereo) {
    statePoses(all, [&root](std::vector<Remark>& remarks) {
      return std::vector<SE3>{SE3(), readMotion(root.at("Stereo.T_c1_c2"), remarks).inverse()};
    });
  }
  for (StatedCamera& camera : all.cameras) {
    remarkUnknownKeys(root, knownKeys(root), camera);
    remarkNotCarried(root, words(is_stereo ? kTransforms : "Stereo.T_c1_c2 " + kTransforms), camera);
    remarkRawCameras(root, camera);
  }
  return all;
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  const NamedCamera& named = cameras.front();
  const LensLayout& lens = layoutOf(kWritten, named.camera.modelId());
  const std::vector<std::string> names = words(lens.order);
  const std::vector<double> values = listedOrder(lens, named.camera);
  std::string text = fmt::format("%YAML:1.0\n---\nFile.version: \"1.0\"\n\nCamera.type: \"{}\"\n", lens.name);
  for (std::size_t i = 0; i < names.size(); ++i)
    text += fmt::format("Camera1.{}: {}\n", names[i], realText(values[i]));
  return text + fmt::format("\nCamera.width: {}\nCamera.height: {}\n", named.image_size.width,
                            named.image_size.height);
}

}  // namespace orbslam_format

const CameraFormat& orbslam() {
  using namespace orbslam_format;
  static const CameraFormat kFormat = {.id = "orbslam",
                                       .title = "ORB-SLAM3 settings (YAML)",
                                       .aliases = "orb-slam2 orb-slam3",
                                       .models = {"pinhole", "radtan", "kannala_brandt"},
                                       .max_read = 2,
                                       .reads_poses = true,
                                       .marks = {"Camera.fx", "Camera1.fx", "Camera.type"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
