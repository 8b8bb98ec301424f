// SPDX-License-Identifier: MIT
// nerfstudio's transforms.json, and instant-ngp's, from which it derives: fl_x fl_y cx cy w h and
// coefficients at the top level, or in each frame (nerfstudio's documentation, "Data conventions";
// nerfstudio_dataparser.py; the names in cameras.py). A perspective camera has k1 k2 k3 p1 p2 as OpenCV's
// five, and a k4 for the eighth power that no other format has; a fisheye has k1 k2 k3 k4. Pixels count from
// the image's corner: the centre of the first one is (0.5, 0.5). The axes that point up and back concern the
// poses, which are not read.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include "alidade/core/aliases.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"

namespace alidade::detail::formats {
namespace nerfstudio_format {

constexpr double kOrigin = 0.5;  // px, of the first pixel's centre

constexpr std::array<LensLayout, 3> kWritten = {
    {{"PINHOLE", "pinhole", "fx fy cx cy"},
     {"OPENCV", "radtan", "fx fy cx cy k1 k2 k3 p1 p2"},
     {"OPENCV_FISHEYE", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4"}}};
const std::string kFisheye = "OPENCV_FISHEYE";
const std::string kPerspective = "OPENCV PINHOLE SIMPLE_PINHOLE SIMPLE_RADIAL RADIAL PERSPECTIVE ";
// Keys by which instant-ngp selects special lenses, regardless of the rest of the file.
constexpr std::array kOtherLenses = {"ftheta_p0", "latlong", "equirectangular", "orthographic"};

// Keys of a frame's camera.
const std::string kCameraKeys =
    "camera_model fl_x fl_y cx cy w h k1 k2 k3 k4 p1 p2 is_fisheye camera_angle_x camera_angle_y ";
// Poses, images and training settings, not part of the camera.
const std::string kOtherKeys =
    "frames applied_transform applied_scale ply_file_path orientation_override train_filenames val_filenames "
    "test_filenames aabb_scale scale offset fl_y_is_fl_x enable_depth_loading integer_depth_scale";

bool recognises(const CameraDocument& document) {
  return document.has("fl_x") || document.has("camera_angle_x") ||
         (document.has("frames") && !document.has("alidade_camera"));
}

constexpr std::array kTopCoefficients = {"k1", "k2", "k3", "p1", "p2"};

// Keys at the top level take precedence over those of a frame. Coefficients come from only one of the two.
struct Intrinsics {
  YamlNode top;
  YamlNode frame;

  [[nodiscard]] std::optional<YamlNode> find(const std::string& key) const {
    const auto node = top.find(key);
    return node ? node : frame.find(key);
  }
  [[nodiscard]] StatedNumber number(const std::string& key) const {
    if (const auto node = find(key)) return statedNumber(*node);
    return statedNumber(frame.at(key));  // reports that it is missing
  }
  [[nodiscard]] StatedNumber coefficient(const std::string& key) const {
    const bool is_at_top = std::any_of(kTopCoefficients.begin(), kTopCoefficients.end(),
                                       [this](const char* name) { return top.has(name); });
    const auto node = (is_at_top ? top : frame).find(key);
    return node && !node->isNull() ? statedNumber(*node) : StatedNumber{};
  }
};

// True if camera_model names a fisheye.
bool isFisheyeModel(const YamlNode& model) {
  const std::string name = model.text();
  const std::vector<std::string> known = words(kPerspective + kFisheye);
  if (std::find(known.begin(), known.end(), name) != known.end()) return name == kFisheye;
  const auto names = mapped(known, [](const std::string& other) { return AliasedName{other}; });
  throw UnsupportedCamera(model.error(
      "'" + name + "'", "one of " + join(known, ", "),
      didYouMeanOne(name, names, "use one of these models in the program that calibrated the images")));
}

bool isFisheye(const Intrinsics& intrinsics) {
  const auto model = intrinsics.find("camera_model");
  const auto flag = intrinsics.find("is_fisheye");
  if (!model) return flag && flag->boolean();
  const bool is_fisheye = isFisheyeModel(*model);
  if (flag && flag->boolean() != is_fisheye) {
    throw flag->error(
        "'" + flag->text() + "' and a camera_model of '" + model->text() + "' at " + model->where(),
        "values that agree", "remove the wrong one");
  }
  return is_fisheye;
}

void refuseOtherLenses(const Intrinsics& intrinsics) {
  for (const char* key : kOtherLenses) {
    const auto node = intrinsics.find(key);
    if (!node || node->isNull() || (node->isScalar() && node->text() == "false")) continue;
    throw UnsupportedCamera(node->error(std::string("an instant-ngp lens of type '") + key + "'",
                                        "a camera with the model OPENCV or OPENCV_FISHEYE",
                                        "calibrate the images with one of these models"));
  }
}

// Names the key that may mean the focal length if no known key states it.
void refuseNoFocalLength(const Intrinsics& intrinsics) {
  if (intrinsics.find("fl_x") || intrinsics.find("camera_angle_x")) return;
  for (const char* key : {"fx", "focal_x", "focal", "focal_length", "fl", "f"}) {
    const auto other = intrinsics.find(key);
    if (!other) continue;
    throw other->error(std::string("'") + key + "' but no 'fl_x'", "fl_x, fl_y, cx and cy, in pixels",
                       "if it is the focal length in pixels, rename it");
  }
  throw intrinsics.frame.error("no key 'fl_x'",
                               "fl_x, fl_y, cx and cy at the top of the file or in each frame", "add them");
}

bool hasAngleAlone(const Intrinsics& intrinsics) {
  return !intrinsics.find("fl_x") && intrinsics.find("camera_angle_x");
}

// The focal length at which an image of `side` pixels spans the field angle of `node`.
double focalOf(const YamlNode& node, int side) {
  const double angle = node.number();
  if (!(angle > 0 && angle < std::numbers::pi))
    throw node.error("'" + node.text() + "'", "a field of view in radians between 0 and pi");
  return 0.5 * side / std::tan(0.5 * angle);
}

// A field angle beside a focal length must agree with it; otherwise one of them belongs to a different camera
// or image. For a fisheye, colmap2nerf.py computes the angle as for a pinhole; others use the lens itself.
void refuseOtherAngle(const Intrinsics& intrinsics, const char* angle_key, const char* focal_key,
                      bool is_fisheye, int side) {
  constexpr double kSameShare = 0.01;
  const auto angle = intrinsics.find(angle_key);
  const auto stated = intrinsics.find(focal_key);
  if (!angle || angle->isNull() || !stated) return;
  const double focal = statedNumber(*stated).value;
  const auto isSameFocal = [focal](double other) { return std::abs(focal - other) <= kSameShare * other; };
  if (is_fisheye && isSameFocal(side / statedNumber(*angle).value)) return;
  const double told = focalOf(*angle, side);
  if (isSameFocal(told)) return;
  throw angle->error("'" + angle->text() + "', which for " + std::to_string(side) +
                         " pixels means a focal length of " + exactText(told),
                     "the value of " + stated->where() + ", which is " + stated->text(),
                     "correct or remove the wrong one");
}

// instant-ngp's files may state only the angle that the image width spans; missing values are completed as in
// its own reader (nerf_loader.cu).
std::vector<StatedNumber> pinholeOfAngle(const Intrinsics& intrinsics, bool is_fisheye,
                                         std::optional<ImageSize> size, std::vector<Remark>& remarks) {
  const YamlNode angle = *intrinsics.find("camera_angle_x");
  if (is_fisheye) {
    throw angle.error("a fisheye with camera_angle_x but no fl_x", "fl_x, fl_y, cx and cy",
                      "copy them from the tool that wrote the file");
  }
  if (!size) {
    throw angle.error("camera_angle_x, but neither fl_x nor the image size",
                      "fl_x, fl_y, cx and cy, or w and h together with camera_angle_x",
                      "add --image-size WIDTHxHEIGHT, the size of the images in pixels");
  }
  const auto angle_y = intrinsics.find("camera_angle_y");
  const bool has_y = intrinsics.find("fl_y") || angle_y;
  const StatedNumber fx = {focalOf(angle, size->width)};
  const StatedNumber fy = intrinsics.find("fl_y") ? intrinsics.number("fl_y")
                          : angle_y               ? StatedNumber{focalOf(*angle_y, size->height)}
                                                  : fx;
  remarks.push_back({"assumed", angle.where() +
                                    ": there is no fl_x; assumed to be 0.5 w / tan(camera_angle_x / 2) = " +
                                    exactText(fx.value) + (has_y ? "" : ", and fl_y the same")});
  const auto middle = [&](const char* key, int side) {
    if (intrinsics.find(key)) return intrinsics.number(key);
    remarks.push_back(
        {"assumed", angle.where() + ": there is no " + key + "; assumed to be the image centre"});
    return StatedNumber{0.5 * side};
  };
  const StatedNumber cx = middle("cx", size->width);
  return {fx, fy, cx, middle("cy", size->height)};
}

std::vector<StatedNumber> parametersOf(const Intrinsics& intrinsics, bool is_fisheye,
                                       std::optional<ImageSize> size, std::vector<Remark>& remarks) {
  std::vector<StatedNumber> parameters;
  if (hasAngleAlone(intrinsics)) {
    parameters = pinholeOfAngle(intrinsics, is_fisheye, size, remarks);
  } else {
    for (const char* key : {"fl_x", "fl_y", "cx", "cy"}) parameters.push_back(intrinsics.number(key));
  }
  takeOrigin(parameters, kOrigin);
  const std::vector<std::string> keys = words(is_fisheye ? "k1 k2 k3 k4" : "k1 k2 p1 p2 k3");
  for (const std::string& key : keys) parameters.push_back(intrinsics.coefficient(key));
  for (const char* key : {"k4", "p1", "p2"}) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end() || intrinsics.coefficient(key).value == 0)
      continue;
    throw UnsupportedCamera(intrinsics.find(key)->error(
        std::string(key) + " = " + intrinsics.find(key)->text(),
        is_fisheye ? "0, because a fisheye of this format has no tangential terms"
                   : "0, because a perspective camera of this format has no k4",
        is_fisheye ? "calibrate the images without them"
                   : "if it is a fisheye, write OPENCV_FISHEYE; otherwise calibrate the images without it"));
  }
  return parameters;
}

StatedCamera readOne(const Intrinsics& intrinsics, const ReadOptions& options) {
  refuseOtherLenses(intrinsics);
  const bool is_fisheye = isFisheye(intrinsics);
  refuseNoFocalLength(intrinsics);
  std::vector<Remark> remarks;
  const auto size = sizeOfSides({intrinsics.top, intrinsics.frame}, "w", "h", options.image_size, remarks);
  const auto known_size = size ? size : options.image_size;
  if (known_size) {
    refuseOtherAngle(intrinsics, "camera_angle_x", "fl_x", is_fisheye, known_size->width);
    refuseOtherAngle(intrinsics, "camera_angle_y", "fl_y", is_fisheye, known_size->height);
  }
  const std::vector<StatedNumber> parameters = parametersOf(intrinsics, is_fisheye, known_size, remarks);
  const bool is_plain = !is_fisheye && areZero(std::span(parameters).subspan(4));
  const char* telling = hasAngleAlone(intrinsics) ? "camera_angle_x" : "fl_x";
  StatedCamera camera = stateCamera(
      intrinsics.find(telling)->where(), is_fisheye ? "kannala_brandt" : (is_plain ? "pinhole" : "radtan"),
      std::span(parameters).first(is_plain ? 4 : parameters.size()), size, remarks);
  if (!intrinsics.find("camera_model") && !intrinsics.find("is_fisheye")) {
    camera.remarks.push_back(
        {"assumed",
         intrinsics.top.where() + ": there is no camera_model; assumed to be OPENCV, as in nerfstudio"});
  }
  remarkUnknownKeys(intrinsics.top, words(kCameraKeys + kOtherKeys), camera);
  return camera;
}

bool saysSame(const YamlNode& a, const YamlNode& b) {
  const auto x = parseDouble(a.text());
  const auto y = parseDouble(b.text());
  return a.text() == b.text() || (x && y && *x == *y);
}

// Readers of this format disagree on whether the top level or the frame takes precedence.
void refuseOtherCamera(const YamlNode& top, const YamlNode& frame) {
  for (const std::string& key : words(kCameraKeys)) {
    const auto theirs = top.find(key);
    const auto own = frame.find(key);
    if (!theirs || !own || !theirs->isScalar() || !own->isScalar() || saysSame(*theirs, *own)) continue;
    throw own->error("'" + own->text() + "' where " + theirs->where() + " says '" + theirs->text() + "'",
                     "the same as at the top",
                     "correct the wrong one, or state the cameras in the frames alone");
  }
}

bool isSame(const StatedCamera& a, const StatedCamera& b) {
  return a.camera.modelId() == b.camera.modelId() && a.image_size == b.image_size &&
         std::equal(a.camera.parameters().begin(), a.camera.parameters().end(),
                    b.camera.parameters().begin());
}

// Everything that a frame states about its camera. Frames with equal statements share one camera, made once.
std::string statementOf(const YamlNode& frame) {
  std::string statement;
  for (const std::string& key : words(kCameraKeys)) {
    const auto node = frame.find(key);
    if (node && node->isScalar()) statement += key + "=" + node->text() + "\n";
  }
  return statement;
}

CameraSource read(const CameraDocument& document, const ReadOptions& options) {
  const YamlNode& root = document.root();
  const auto list = root.find("frames");
  const bool has_frames = list && list->isSequence() && !list->items().empty();
  if (!has_frames) {
    if (list && !list->isSequence() && !root.has("fl_x") && !root.has("camera_angle_x"))
      static_cast<void>(list->items());  // reports that it is not a list
    return {.cameras = {readOne({root, root}, options)}};
  }
  constexpr std::size_t kMaxFrames = 100'000;
  constexpr std::size_t kMaxCameras = 1000;
  const std::vector<YamlNode> frames = list->items();
  if (frames.size() > kMaxFrames) throw list->error(std::to_string(frames.size()) + " frames", "fewer");
  // Each frame states a camera, and usually all are equal.
  CameraSource all;
  std::set<std::string> statements;
  for (const YamlNode& frame : frames) {
    if (!statements.insert(statementOf(frame)).second) continue;
    const auto path = frame.find("file_path");
    const std::string name = path ? path->text() : "";
    const std::size_t num_before = all.cameras.size();
    refuseOtherCamera(root, frame);
    all.add(name, [&] { return readOne({root, frame}, options); });
    if (all.cameras.size() > num_before &&
        std::any_of(all.cameras.begin(), all.cameras.end() - 1,
                    [&all](const StatedCamera& other) { return isSame(other, all.cameras.back()); }))
      all.cameras.pop_back();
    if (all.cameras.size() + all.refused.size() > kMaxCameras)
      throw frame.error("more than " + std::to_string(kMaxCameras) + " different cameras", "fewer");
  }
  if (all.cameras.size() == 1 && all.refused.empty()) all.cameras.front().name.clear();
  return all;
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  const NamedCamera& named = cameras.front();
  const LensLayout& lens = layoutOf(kWritten, named.camera.modelId());
  const std::vector<std::string> names = words(lens.order);
  const std::vector<double> values = listedOrder(lens, named.camera, kOrigin);
  nlohmann::ordered_json document = {
      {"camera_model", lens.name}, {"w", named.image_size.width}, {"h", named.image_size.height}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string key = names[i] == "fx" ? "fl_x" : (names[i] == "fy" ? "fl_y" : names[i]);
    document[key] = values[i];
  }
  document["frames"] = nlohmann::ordered_json::array();
  return document.dump(2) + "\n";
}

}  // namespace nerfstudio_format

const CameraFormat& nerfstudio() {
  using namespace nerfstudio_format;
  static const CameraFormat kFormat = {.id = "nerfstudio",
                                       .title = "nerfstudio transforms.json",
                                       .aliases = "nerf transforms_json instant-ngp",
                                       .models = {"pinhole", "radtan", "kannala_brandt"},
                                       .max_read = CameraFormat::kAnyNumber,
                                       .marks = {"fl_x", "camera_angle_x"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
