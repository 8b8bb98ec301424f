// SPDX-License-Identifier: MIT
// ORB-SLAM3's settings (OpenCV's YAML; src/Settings.cc): Camera.type, Camera.width, Camera.height, and keys
// Camera1.fx ... of the first camera, Camera2.fx ... of the second. Files without File.version, and those of
// ORB-SLAM2, call the first camera Camera.fx ... PinHole has k1 k2 p1 p2 [k3], KannalaBrandt8 k1 k2 k3 k4.
// Pixel (0, 0) is a pixel's centre.
#include <array>
#include <string>

#include "alidade/core/text.h"
#include "alidade/io/formats/camera_document.h"
#include "alidade/io/formats/format_text.h"
#include "alidade/io/formats/formats.h"
#include "alidade/io/formats/lens_layout.h"

namespace alidade::formats {
namespace {

using detail::CameraDocument;
using detail::LensLayout;
using detail::StatedNumber;
using detail::YamlNode;

constexpr LensLayout kPlain = {"PinHole", "pinhole", "fx fy cx cy"};
constexpr LensLayout kRadtan = {"PinHole", "radtan", "fx fy cx cy k1 k2 p1 p2"};
constexpr LensLayout kRadtan5 = {"PinHole", "radtan", "fx fy cx cy k1 k2 p1 p2 k3"};
constexpr LensLayout kFisheye = {"KannalaBrandt8", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4"};
constexpr std::array<LensLayout, 3> kWritten = {kPlain, kRadtan5, kFisheye};

constexpr std::string_view kNumbers = "fx fy cx cy k1 k2 k3 k4 p1 p2";
constexpr std::array kPrefixes = {"Camera1", "Camera", "Camera2"};
const std::vector<std::string> kTransforms = {
    "Stereo.T_c1_c2",    "Tbc",    "IMU.T_b_c1", "Camera.newWidth", "Camera.newHeight",
    "Camera.imageScale", "LEFT.R", "RIGHT.R"};
// What else such files hold: not of the camera, by the start of the key.
constexpr std::array kOtherSettings = {"File.",   "ORBextractor.", "Viewer.",        "IMU.",
                                       "Stereo.", "RGBD.",         "System.",        "LEFT.",
                                       "RIGHT.",  "ThDepth",       "DepthMapFactor", "thFarPoints",
                                       "Tbc",     "loopClosing",   "Initializer."};
constexpr std::array kOtherCameraKeys = {"type",
                                         "width",
                                         "height",
                                         "fps",
                                         "RGB",
                                         "bf",
                                         "newWidth",
                                         "newHeight",
                                         "imageScale",
                                         "overlappingBegin",
                                         "overlappingEnd",
                                         "lappingBegin",
                                         "lappingEnd"};

bool recognises(const CameraDocument& document) {
  return document.has("Camera.type") || document.has("Camera.fx") || document.has("Camera1.fx");
}

std::string typeOf(const YamlNode& root) {
  const auto type = root.find("Camera.type");
  if (!type) return "PinHole";
  for (const char* known : {"PinHole", "Rectified", "KannalaBrandt8"}) {
    if (type->text() == known) return known;
  }
  throw UnsupportedCamera(type->error("'" + type->text() + "'", "PinHole, Rectified or KannalaBrandt8"));
}

const LensLayout& lensOf(const YamlNode& root, const std::string& prefix, const std::string& type) {
  if (type == "KannalaBrandt8") return kFisheye;
  if (type == "Rectified") return kPlain;
  if (root.has(prefix + ".k3")) return kRadtan5;
  for (const char* name : {".k1", ".k2", ".p1", ".p2"}) {
    if (root.has(prefix + name)) return kRadtan;
  }
  return kPlain;
}

StatedCamera readOne(const YamlNode& root, const std::string& prefix) {
  const std::string type = typeOf(root);
  const LensLayout& lens = lensOf(root, prefix, type);
  std::vector<std::string> keys;
  for (const std::string& name : detail::listedNames(lens)) keys.push_back(prefix + "." + name);
  std::optional<ImageSize> size;
  if (root.has("Camera.width") || root.has("Camera.height"))
    size = detail::readSize(root.at("Camera.width"), root.at("Camera.height"));
  StatedCamera camera =
      detail::stateCamera(root.at(keys.front()).where(), prefix == "Camera" ? "Camera1" : prefix, lens.model,
                          detail::storageOrder(lens, detail::numbersOf(root, keys)), size);
  if (!root.has("Camera.type")) {
    camera.remarks.push_back(
        {"assumed", root.where() + ": there is no Camera.type; taken as PinHole, as ORB-SLAM2 does"});
  }
  return camera;
}

bool isOfCamera(const std::string& key) {
  for (const char* prefix : kPrefixes) {
    if (!key.starts_with(std::string(prefix) + ".")) continue;
    const std::string name = key.substr(std::string(prefix).size() + 1);
    for (const std::string_view known : split(kNumbers, ' ')) {
      if (name == known) return true;
    }
    for (const char* known : kOtherCameraKeys) {
      if (name == known) return true;
    }
  }
  return false;
}

std::vector<std::string> knownKeys(const YamlNode& root) {
  std::vector<std::string> known;
  for (const std::string& key : root.keys()) {
    const bool is_setting = std::any_of(kOtherSettings.begin(), kOtherSettings.end(),
                                        [&key](const char* start) { return key.starts_with(start); });
    if (is_setting || isOfCamera(key)) known.push_back(key);
  }
  return known;
}

// The first camera has two sets of names, of which ORB-SLAM reads one. What the other set says has to be the
// same; a coefficient of 0 is as if it were not there.
void refuseMixedNames(const YamlNode& root, const std::string& own, const std::string& other) {
  for (const std::string_view name : split(kNumbers, ' ')) {
    const auto ours = root.find(own + "." + std::string(name));
    const auto theirs = root.find(other + "." + std::string(name));
    if (!theirs) continue;
    const StatedNumber number = detail::statedNumber(*theirs);
    if (ours && detail::statedNumber(*ours).value == number.value) continue;
    if (ours) {
      throw theirs->error("'" + theirs->text() + "', where " + ours->where() + " says '" + ours->text() + "'",
                          "keys of one kind for the first camera, or both to say the same",
                          "remove the wrong one");
    }
    if (number.value == 0) continue;
    throw theirs->error("'" + other + "." + std::string(name) + "' without '" + own + "." +
                            std::string(name) + "', beside " + root.at(own + ".fx").where(),
                        "keys of one kind for the first camera",
                        "rename it, or remove it if it is something else");
  }
}

StatedCameras read(const CameraDocument& document, const ReadOptions&) {
  const YamlNode& root = document.root();
  StatedCameras all;
  const bool is_older = !root.has("Camera1.fx") && root.has("Camera.fx");
  if (root.has("Camera1.fx") || is_older)
    refuseMixedNames(root, is_older ? "Camera" : "Camera1", is_older ? "Camera1" : "Camera");
  all.add("Camera1", [&] { return readOne(root, is_older ? "Camera" : "Camera1"); });
  if (root.has("Camera2.fx")) all.add("Camera2", [&] { return readOne(root, "Camera2"); });
  for (StatedCamera& camera : all.cameras) {
    detail::remarkUnknownKeys(root, knownKeys(root), camera);
    detail::remarkNotCarried(root, kTransforms, camera);
  }
  return all;
}

std::string write(std::span<const NamedCamera> cameras) {
  const NamedCamera& named = cameras.front();
  const LensLayout& lens = detail::layoutOf(kWritten, named.camera.modelId());
  const std::vector<std::string> names = detail::listedNames(lens);
  const std::vector<double> values = detail::listedOrder(lens, named.camera);
  std::string text =
      "%YAML:1.0\n---\nFile.version: \"1.0\"\n\nCamera.type: \"" + std::string(lens.name) + "\"\n";
  for (std::size_t i = 0; i < names.size(); ++i)
    text += "Camera1." + names[i] + ": " + detail::realText(values[i]) + "\n";
  return text + "\nCamera.width: " + std::to_string(named.image_size.width) +
         "\nCamera.height: " + std::to_string(named.image_size.height) + "\n";
}

}  // namespace

const CameraFormat& orbslam() {
  static const CameraFormat kFormat = {.id = "orbslam",
                                       .title = "ORB-SLAM3 settings (YAML)",
                                       .models = {"pinhole", "radtan", "kannala_brandt"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::formats
