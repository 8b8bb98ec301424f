// SPDX-License-Identifier: MIT
// MATLAB's cameraIntrinsics, cameraParameters and stereoParameters (Computer Vision Toolbox), as JSON by
// jsonencode(toStruct(params)) or jsonencode(params).
// ImageSize is [rows, columns]; IntrinsicMatrix is the transpose of K; RadialDistortion has k1 k2 [k3],
// TangentialDistortion p1 p2, by OpenCV's formulas. fisheyeIntrinsics and fisheyeParameters have Scaramuzza's
// lens: MappingCoefficients a0 a2 a3 a4, with rays forward. Pixels count from 1: the centre of the first one
// is (1, 1).
#include <algorithm>
#include <array>
#include <string>

#include <nlohmann/json.hpp>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/ocam_numbers.h"

namespace alidade::detail::formats {
namespace matlab_format {

constexpr std::size_t kMostCameras = 1000;  // aliases could stand for very many
constexpr double kOrigin = 1;               // px, of the first pixel's centre
constexpr LensLayout kLens = {"cameraIntrinsics", "radtan", "fx fy cx cy k1 k2 k3 p1 p2"};

// Each of these identifies a camera; the last one a fisheye.
constexpr std::array kTelling = {"FocalLength", "IntrinsicMatrix", "RadialDistortion", "MappingCoefficients"};
constexpr std::array kStereo = {"CameraParameters1", "CameraParameters2"};
const std::string kPoses = "RotationOfCamera2 TranslationOfCamera2 PoseCamera2 ";
// Properties of the calibration, not of the camera.
const std::string kOtherKeys =
    "FocalLength PrincipalPoint ImageSize RadialDistortion TangentialDistortion Skew K IntrinsicMatrix "
    "Intrinsics CameraParameters1 CameraParameters2 FundamentalMatrix EssentialMatrix RectificationParams "
    "MeanReprojectionError NumPatterns WorldPoints WorldUnits EstimateSkew NumRadialDistortionCoefficients "
    "EstimateTangentialDistortion RotationVectors RotationMatrices TranslationVectors PatternExtrinsics "
    "ReprojectionErrors ReprojectedPoints DetectedKeypoints Version";
const std::string kFisheyeKeys = " MappingCoefficients DistortionCenter StretchMatrix EstimateAlignment";

bool isCamera(const YamlNode& node) {
  return std::any_of(kTelling.begin(), kTelling.end(), [&node](const char* key) { return node.has(key); });
}

// Newer objects have the properties of a camera in a nested object.
YamlNode cameraIn(const YamlNode& node) {
  const auto inner = node.find("Intrinsics");
  return inner && inner->isMap() ? *inner : node;
}

// An array of structs is a list of cameras.
bool recognises(const CameraDocument& document) {
  if (!document.isTree()) return false;
  const YamlNode& root = document.root();
  if (root.isSequence()) return root.node().size() > 0 && isCamera(cameraIn(root.items(1).front()));
  if (isCamera(cameraIn(root))) return true;
  return std::any_of(kStereo.begin(), kStereo.end(),
                     [&root](const char* key) { return root.has(key) && isCamera(cameraIn(root.at(key))); });
}

[[noreturn]] void refuseSkew(const YamlNode& node, const std::string& value) {
  throw UnsupportedCamera(node.error("skew " + value, "0: cameras with skewed pixels are not supported",
                                     "calibrate without EstimateSkew"));
}

std::vector<StatedNumber> readTransposed(const YamlNode& matrix) {
  const std::vector<StatedNumber> m = statedNumbers(matrix, 9);
  if (m[1].value != 0 || m[2].value != 0 || m[5].value != 0 || m[8].value != 1) {
    throw matrix.error(
        "a matrix that is not an IntrinsicMatrix", "fx 0 0, skew fy 0, cx cy 1, row by row",
        m[6].value == 0 && m[7].value == 0 ? "transpose it, or rename it to K" : "export it again");
  }
  if (m[3].value != 0) refuseSkew(matrix, exactText(m[3].value));
  return {m[0], m[4], m[6], m[7]};
}

// fx fy cx cy, from the properties that name them or from a matrix; all must agree. In newer objects, `outer`
// repeats the numbers in `node`, its Intrinsics.
std::vector<StatedNumber> readPinhole(const YamlNode& node, const YamlNode& outer) {
  if (const auto skew = node.find("Skew"); skew && skew->number() != 0) refuseSkew(*skew, skew->text());
  std::vector<StatedNumber> first;
  std::string first_text;
  const auto take = [&](const std::string& name, const YamlNode& place,
                        const std::vector<StatedNumber>& parameters) {
    const auto numbers = mapped(parameters, [](const StatedNumber& n) { return exactText(n.value); });
    const std::string text = name + " (fx fy cx cy = " + join(numbers, " ") + ")";
    if (first.empty()) {
      first = parameters;
      first_text = text + " at " + place.where();
    } else if (!isSameStated(parameters, first)) {
      throw place.error(text + " and a different " + first_text, "values that agree", "remove the wrong one");
    }
  };
  const auto takeAll = [&take](const YamlNode& map) {
    if (const auto focal = map.find("FocalLength")) {
      std::vector<StatedNumber> parameters = statedNumbers(*focal, 2);
      append(parameters, statedNumbers(map.at("PrincipalPoint"), 2));
      take("FocalLength and PrincipalPoint", *focal, parameters);
    }
    if (const auto matrix = map.find("K")) take("K", *matrix, readCameraMatrix(*matrix));
    if (const auto matrix = map.find("IntrinsicMatrix"))
      take("IntrinsicMatrix", *matrix, readTransposed(*matrix));
  };
  takeAll(node);
  if (first.empty()) static_cast<void>(node.at("FocalLength"));  // reports that it is missing
  if (node.where() != outer.where()) takeAll(outer);
  return first;
}

std::vector<StatedNumber> readCoefficients(const YamlNode& node, const char* key, std::size_t min_count,
                                           std::size_t max_count) {
  const auto list = node.find(key);
  if (!list) return std::vector<StatedNumber>(max_count);
  std::vector<StatedNumber> numbers = statedNumbers(*list);
  if (numbers.size() < min_count || numbers.size() > max_count) {
    throw list->error(std::to_string(numbers.size()) + " coefficients",
                      min_count == max_count
                          ? std::to_string(max_count)
                          : std::to_string(min_count) + " or " + std::to_string(max_count));
  }
  numbers.resize(max_count);
  return numbers;
}

// Empty if the calibration did not store it.
std::optional<ImageSize> statedImageSize(const YamlNode& node) {
  const auto list = node.find("ImageSize");
  if (!list || list->isNull()) return std::nullopt;
  const std::vector<YamlNode> sides = list->items();
  if (sides.empty()) return std::nullopt;
  if (sides.size() != 2) throw list->error(std::to_string(sides.size()) + " numbers", "rows and columns");
  return readSize(sides[1], sides[0]);
}

// fisheyeIntrinsics: Scaramuzza's lens without the coefficient of the first power.
StatedCamera readFisheye(const YamlNode& node) {
  const YamlNode listed = node.at("MappingCoefficients");
  OcamNumbers numbers = {.polynomial = statedNumbers(listed), .affine = {}, .centre = {}, .origin = kOrigin};
  if (numbers.polynomial.empty()) throw listed.error("no number", "a0 a2 a3 a4");
  numbers.polynomial.insert(numbers.polynomial.begin() + 1, StatedNumber());
  std::ranges::copy(statedNumbers(node.at("DistortionCenter"), 2), numbers.centre.begin());
  const std::vector<StatedNumber> A = statedNumbers(node.at("StretchMatrix"), 4);
  if (A[3].value != 1)
    throw node.at("StretchMatrix").error("another last element than 1", "[[c, d], [e, 1]]");
  std::copy_n(A.begin(), 3, numbers.affine.begin());
  StatedCamera camera = stateOcam(listed.where(), numbers, statedImageSize(node));
  remarkUnknownKeys(node, words(kPoses + kOtherKeys + kFisheyeKeys), camera);
  return camera;
}

StatedCamera readOne(const YamlNode& outer) {
  const YamlNode node = cameraIn(outer);
  if (node.has("MappingCoefficients")) return readFisheye(node);
  std::vector<StatedNumber> parameters = readPinhole(node, outer);
  append(parameters, readCoefficients(node, "RadialDistortion", 2, 3));
  append(parameters, readCoefficients(node, "TangentialDistortion", 2, 2));
  parameters = storageOrder(kLens, parameters);
  takeOrigin(parameters, kOrigin);
  StatedCamera camera = stateCamera(node.where(), kLens.model, parameters, statedImageSize(node));
  for (const char* key : {"RadialDistortion", "TangentialDistortion"}) {
    if (node.has(key)) continue;
    camera.remarks.push_back({"assumed", node.where() + ": there is no " + key + "; assumed to be zero"});
  }
  remarkUnknownKeys(node, words(kPoses + kOtherKeys), camera);
  return camera;
}

CameraSource read(const CameraDocument& document, const ReadOptions&) {
  const YamlNode& root = document.root();
  if (isCamera(cameraIn(root))) return {.cameras = {readOne(root)}};
  CameraSource all;
  if (root.isSequence()) {
    if (root.node().size() > kMostCameras) throw root.error("more than 1000 cameras", "fewer");
    for (const YamlNode& item : root.items()) all.add("", [&item] { return readOne(item); });
    return all;
  }
  for (const char* key : kStereo) {
    const YamlNode node = root.at(key);
    all.add(key, [&] { return readOne(node); });
  }
  for (StatedCamera& camera : all.cameras) remarkNotCarried(root, words(kPoses), camera);
  return all;
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  const NamedCamera& named = cameras.front();
  nlohmann::ordered_json document;
  if (named.camera.modelId() == "ocam") {
    const OcamNumbers numbers = ocamNumbers(named.camera, false, kOrigin);
    std::vector<double> a = mapped(numbers.polynomial, &StatedNumber::value);
    a.erase(a.begin() + 1);
    while (a.size() > 4 && a.back() == 0) a.pop_back();
    const auto& [c, d, e] = numbers.affine;
    document = {{"MappingCoefficients", a},
                {"DistortionCenter", {numbers.centre[0].value, numbers.centre[1].value}},
                {"StretchMatrix", {{c.value, d.value}, {e.value, 1.0}}}};
  } else {
    const std::vector<double> listed = listedOrder(kLens, named.camera, kOrigin);
    const auto list = [&listed](std::size_t first, std::size_t count) {
      const auto begin = listed.begin() + static_cast<std::ptrdiff_t>(first);
      return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(count));
    };
    document = {{"FocalLength", list(0, 2)},
                {"PrincipalPoint", list(2, 2)},
                {"RadialDistortion", list(4, 3)},
                {"TangentialDistortion", list(7, 2)},
                {"Skew", 0.0}};
  }
  document["ImageSize"] = {named.image_size.height, named.image_size.width};
  return document.dump(2) + "\n";
}

}  // namespace matlab_format

const CameraFormat& matlab() {
  using namespace matlab_format;
  static const CameraFormat kFormat = {
      .id = "matlab",
      .title = "MATLAB camera parameters (JSON)",
      .models = {"radtan", "ocam"},
      .max_read = CameraFormat::kAnyNumber,
      .marks = {"FocalLength", "PrincipalPoint", "RadialDistortion", "IntrinsicMatrix"},
      .recognises = recognises,
      .read = read,
      .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
