// SPDX-License-Identifier: MIT
// OpenCV's FileStorage: YAML with the header %YAML:1.0, XML, or JSON. Each program chooses its own node
// names; known here are those of OpenCV's samples (calibration, stereo_calib, the tutorial
// camera_calibration, omnidir), of its application interactive-calibration, and the most common others.
// Coefficients: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]] as in cv::projectPoints, k1 k2 k3 k4 as in
// cv::fisheye. Pixel (0, 0) is a pixel's centre.
#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>

#include "alidade/camera/model_traits.h"
#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade::detail::formats {
namespace opencv_format {

const std::vector<std::string> kMatrixKeys =
    words("camera_matrix Camera_Matrix cameraMatrix CameraMatrix camera_Matrix intrinsic_matrix mtx K M");
const std::vector<std::string> kCoefficientKeys = words(
    "distortion_coefficients Distortion_Coefficients distCoeffs DistCoeffs dist_coeffs dist_coeff distortion "
    "dist D");
const std::string kPair = "R T ";
const std::string kStereo = "R1 R2 P1 P2 extrinsic_parameters ";
// Names with a meaning, or that OpenCV's samples write beside the camera.
const std::vector<std::string> kOtherKeys = words(
    kPair + kStereo +
    "P rectification_matrix projection_matrix Q E F image_width image_height image_Width image_Height image_size imageSize cameraResolution width "
    "height fisheye_model distortion_model xi camera_name calibration_time calibration_Time calibrationDate "
    "framesCount nframes nr_of_frames nrOfFrames board_width board_height board_Width board_Height "
    "square_size square_Size fix_aspect_ratio aspectRatio flags flagValue avg_reprojection_error "
    "avg_reprojection_Error per_view_reprojection_errors cameraMatrix_std_dev camera_matrix_std_dev "
    "dist_coeffs_std_dev distortion_coefficients_std_dev image_points grid_points");

std::optional<std::string> findKey(const YamlNode& root, const std::vector<std::string>& keys,
                                   const std::string& suffix) {
  std::optional<std::string> found;
  for (const std::string& key : keys) {
    if (!root.has(key + suffix)) continue;
    if (found)
      throw root.at(key + suffix)
          .error("'" + (key + suffix) + "' and '" + *found + "'", "only one of them", "remove the other");
    found = key + suffix;
  }
  return found;
}

// A camera without coefficients is a pinhole only if no remaining key may hold its coefficients.
void refuseLeftOver(const YamlNode& matrix, const YamlNode& root) {
  for (const std::string& name : root.keys()) {
    const YamlNode node = root.at(name);
    const bool is_matrix =
        node.isMap() && node.has("data") && (node.has("sizes") || (node.has("rows") && node.has("cols")));
    if (std::find(kOtherKeys.begin(), kOtherKeys.end(), name) != kOtherKeys.end() || name.starts_with("x_") ||
        !(is_matrix || node.isSequence()))
      continue;
    if (is_matrix && !node.at("data").isSequence()) continue;  // one number
    std::vector<YamlNode> items = (is_matrix ? node.at("data") : node).items();
    if (items.size() == 1 && items.front().isSequence()) items = items.front().items();  // [[k1, k2, ...]]
    const std::size_t count = items.size();
    constexpr std::array<std::size_t, 5> kCounts = {4, 5, 8, 12, 14};
    if (std::find(kCounts.begin(), kCounts.end(), count) == kCounts.end()) continue;
    throw node.error(std::to_string(count) + " numbers in '" + name +
                         "', which may be the distortion coefficients of the camera matrix at " +
                         matrix.where(),
                     "coefficients under a known name, such as distortion_coefficients",
                     "rename them, or remove them if they are something else");
  }
}

// A single camera, or the first and second of a pair ("M1", "M2").
constexpr std::array kSuffixes = {"", "1", "2"};

// The map with the matrices; some programs put them into one of their own.
YamlNode lensesOf(const CameraDocument& document) {
  const auto inner = document.root().find("intrinsics");
  return inner && inner->isMap() ? *inner : document.root();
}

bool recognises(const CameraDocument& document) {
  // ROS and MATLAB use the same names for matrices.
  if (!document.isMap() || ros().recognises(document) || matlab().recognises(document)) return false;
  for (const char* suffix : kSuffixes) {
    if (findKey(lensesOf(document), kMatrixKeys, suffix)) return true;
  }
  return false;
}

std::optional<ImageSize> findSize(const YamlNode& root, const ReadOptions& options,
                                  std::vector<Remark>& remarks) {
  constexpr std::array<std::array<const char*, 2>, 3> kPairs = {
      {{"image_width", "image_height"}, {"image_Width", "image_Height"}, {"width", "height"}}};
  std::optional<ImageSize> found;
  const auto requireSame = [&](const YamlNode& place, bool is_same) {
    if (is_same) return;
    throw place.error("an image size that differs from an earlier one", sizeText(*found),
                      "remove the wrong one");
  };
  const auto take = [&](const YamlNode& place, ImageSize size) {
    requireSame(place, !found || *found == size);
    found = size;
  };
  for (const auto& [width, height] : kPairs) {
    if (root.has(width) && root.has(height)) take(root.at(width), readSize(root.at(width), root.at(height)));
  }
  for (const char* key : {"image_size", "imageSize", "cameraResolution"}) {
    if (root.has(key)) take(root.at(key), readSize(root.at(key)));
  }
  // A single side must agree with the size, if that is known.
  for (const auto& [width, height] : kPairs) {
    if (root.has(width) == root.has(height)) continue;
    if (!found) {
      found = sizeOfSides({root}, width, height, options.image_size, remarks);
    } else {
      const YamlNode side = root.at(root.has(width) ? width : height);
      requireSame(side, side.number() == (root.has(width) ? found->width : found->height));
    }
  }
  return found;
}

// cv::fisheye for 1, an ordinary lens for 0; OpenCV's sample writes no other number.
bool saysFisheye(const YamlNode& flag) {
  const std::string text = flag.text();
  const auto number = parseDouble(text);
  if (text == "true" || number == 1.0) return true;
  if (text == "false" || number == 0.0) return false;
  throw flag.error("'" + text + "'", "1 for a fisheye (cv::fisheye) or 0 for an ordinary lens",
                   "correct it, or remove it and add --read-as radtan or --read-as kannala_brandt");
}

// The model that the file names; "" if it names none.
std::string namedModel(const YamlNode& root) {
  const auto name = root.find("distortion_model");
  if (!name) return "";
  const std::string text = name->text();
  const std::string model = meantName(text, aliasedModels()).value_or("");
  if (model == "kannala_brandt") return model;
  for (const char* plane : {"radtan", "rational", "thin_prism", "pinhole"})
    if (model == plane) return "radtan";
  throw name->error("'" + text + "'",
                    "kannala_brandt, fisheye or equidistant; or radtan, plumb_bob, rational, "
                    "rational_polynomial, thin_prism or pinhole");
}

std::string statedModel(const YamlNode& root) {
  const std::string named = namedModel(root);
  if (!root.has("fisheye_model")) return named;
  std::string flagged = saysFisheye(root.at("fisheye_model")) ? "kannala_brandt" : "radtan";
  if (!named.empty() && named != flagged) {
    throw root.at("fisheye_model")
        .error("'" + root.at("fisheye_model").text() + "' and a distortion_model of '" +
                   root.at("distortion_model").text() + "'",
               "values that agree", "remove the wrong one");
  }
  return flagged;
}

StatedCamera readOne(const CameraDocument& document, const std::string& suffix, const ReadOptions& options) {
  const YamlNode root = lensesOf(document);
  std::vector<Remark> remarks;
  auto size = findSize(root, options, remarks);
  if (!size) size = findSize(document.root(), options, remarks);
  const YamlNode matrix = root.at(*findKey(root, kMatrixKeys, suffix));
  StatedNumber skew;
  std::vector<StatedNumber> parameters = readCameraMatrix(matrix, &skew);
  const auto key = findKey(root, kCoefficientKeys, suffix);
  if (!key) refuseLeftOver(matrix, root);
  // A single value in XML is not a list.
  std::vector<StatedNumber> coefficients = key ? statedNumbers(root.at(*key)) : std::vector<StatedNumber>();
  const YamlNode place = key ? root.at(*key) : matrix;
  const auto flag = root.find("fisheye_model");
  if (root.has("xi") && flag && saysFisheye(*flag)) {
    throw flag->error("'" + flag->text() + "' and 'xi', which belongs to cv::omnidir",
                      "only one of the two lens models", "remove the wrong one");
  }
  std::string_view model = "omni";
  if (const auto xi = root.find("xi")) {  // k1 k2 p1 p2 and the unified model's xi, as cv::omnidir has them
    if (coefficients.size() != 4)
      throw place.error(std::to_string(coefficients.size()) + " distortion coefficients",
                        "4 together with xi");
    parameters.push_back(xi->isMap() ? statedNumbers(*xi, 1).front() : statedNumber(*xi));
  } else {
    const std::string stated = statedModel(root);
    model = openCvModel(place, parameters, coefficients, stated.empty() ? options.model : stated);
  }
  append(parameters, coefficients);
  model = takeSkew(matrix, model, skew, parameters);
  StatedCamera camera = stateCamera(place.where(), model, parameters, size, remarks);
  if (!key)
    camera.remarks.push_back(
        {"assumed", matrix.where() +
                        ": there are no distortion coefficients; the lens is assumed to have no distortion"});
  return camera;
}

CameraSource read(const CameraDocument& document, const ReadOptions& options) {
  const YamlNode root = lensesOf(document);
  std::vector<std::string> known = kOtherKeys;
  known.emplace_back("intrinsics");
  CameraSource all;
  for (const char* suffix : kSuffixes) {
    for (const std::string& key : kMatrixKeys) known.push_back(key + suffix);
    for (const std::string& key : kCoefficientKeys) known.push_back(key + suffix);
    if (findKey(root, kMatrixKeys, suffix))
      all.add(suffix, [&] { return readOne(document, suffix, options); });
  }
  const bool is_pair = all.cameras.size() + all.refused.size() == 2 && statesPair(document);
  for (StatedCamera& camera : all.cameras) {
    remarkUnknownKeys(root, known, camera);
    if (document.has("intrinsics")) remarkUnknownKeys(document.root(), known, camera);
    remarkNotCarried(root, words(is_pair ? kStereo : kPair + kStereo), camera);
  }
  if (is_pair) {
    statePoses(all, [&root](std::vector<Remark>& remarks) {
      return std::vector<SE3>{SE3(), readPair(root, remarks)};
    });
  }
  return all;
}

// Format strings (fmt) for top-level nodes in a notation of OpenCV's FileStorage, and the nodes.
struct NodeWriter {
  const char* head;
  const char* number_format;  // arguments: key, number
  const char* matrix_format;  // arguments: key, numbers of rows and columns, values row by row
  const char* between_values;
  const char* between_nodes;
  const char* tail;
  std::vector<std::string> nodes = {};

  void addNumber(const std::string& key, const std::string& value) {
    nodes.push_back(fmt::format(fmt::runtime(number_format), key, value));
  }
  void addMatrix(const std::string& key, std::size_t rows, std::size_t columns,
                 std::span<const double> values) {
    nodes.push_back(fmt::format(fmt::runtime(matrix_format), key, rows, columns,
                                join(mapped(values, realText), between_values)));
  }
  void addLens(const AnyCamera& camera, const std::string& matrix_key, const std::string& coefficients_key) {
    const std::span<const double> p = camera.parameters();
    std::vector<double> coefficients(p.begin() + 4, p.end());
    double skew = 0;
    if (camera.modelId() == "kannala_brandt_skew") {
      skew = p[0] * coefficients.back();
      coefficients.pop_back();
    }
    addMatrix(matrix_key, 3, 3, std::array{p[0], skew, p[2], 0.0, p[1], p[3], 0.0, 0.0, 1.0});
    if (camera.modelId() == "pinhole") coefficients.assign(5, 0.0);
    if (camera.modelId() == "omni") {
      addNumber("xi", realText(coefficients.front()));  // as in the sample omni_calibration
      coefficients.erase(coefficients.begin());
    }
    addMatrix(coefficients_key, coefficients.size(), 1, coefficients);
  }
};

NodeWriter writerFor(const std::string& path) {
  if (path.ends_with(".xml")) {
    return {.head = "<?xml version=\"1.0\"?>\n<opencv_storage>\n",
            .number_format = "<{0}>{1}</{0}>\n",
            .matrix_format =
                "<{0} type_id=\"opencv-matrix\">\n  <rows>{1}</rows>\n  <cols>{2}</cols>\n  <dt>d</dt>\n"
                "  <data>\n    {3}</data></{0}>\n",
            .between_values = " ",
            .between_nodes = "",
            .tail = "</opencv_storage>\n"};
  }
  if (path.ends_with(".json")) {
    return {.head = "{\n",
            .number_format = "    \"{}\": {}",
            .matrix_format =
                "    \"{}\": {{\n        \"type_id\": \"opencv-matrix\",\n        \"rows\": {},\n"
                "        \"cols\": {},\n        \"dt\": \"d\",\n        \"data\": [{}]\n    }}",
            .between_values = ", ",
            .between_nodes = ",\n",
            .tail = "\n}\n"};
  }
  return {.head = "%YAML:1.0\n---\n",
          .number_format = "{}: {}\n",
          .matrix_format = "{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n",
          .between_values = ", ",
          .between_nodes = "",
          .tail = ""};
}

// The two cameras of a file must have the same size and kind of lens.
void requirePair(std::span<const NamedCamera> cameras) {
  const NamedCamera& first = cameras.front();
  const NamedCamera& second = cameras.back();
  const auto refuse = [&second](const std::string& found, const std::string& expected) {
    throw errorAt(second.where, "found " + found,
                  expected + ", because a file of OpenCV states it once for both cameras",
                  "write each camera to a file of its own (FILE#NAME), or use another format");
  };
  if (first.image_size != second.image_size) {
    refuse("an image of " + sizeText(second.image_size) + " pixels",
           sizeText(first.image_size) + " as of the first camera");
  }
  const auto kindOf = [](const NamedCamera& named) {
    const std::string_view model = named.camera.modelId();
    return model == "kannala_brandt" ? "a fisheye" : model == "omni" ? "an omni" : "an ordinary";
  };
  const std::string kind = kindOf(second);
  if (kind != kindOf(first)) refuse(kind + " lens", std::string(kindOf(first)) + " lens");
  if (kind == "an omni") refuse("two omni lenses", "one, because there is only one xi");
}

std::string write(std::span<const NamedCamera> cameras, const std::string& path) {
  NodeWriter writer = writerFor(path);
  const NamedCamera& first = cameras.front();
  writer.addNumber("image_width", std::to_string(first.image_size.width));
  writer.addNumber("image_height", std::to_string(first.image_size.height));
  writer.addNumber("fisheye_model", first.camera.modelId().starts_with("kannala_brandt") ? "1" : "0");
  if (cameras.size() == 1) {
    writer.addLens(first.camera, "camera_matrix", "distortion_coefficients");
  } else {
    requirePair(cameras);
    writer.addLens(first.camera, "M1", "D1");
    writer.addLens(cameras.back().camera, "M2", "D2");
    const std::vector<SE3> poses = posesFromFirst(cameras);
    if (!poses.empty()) {
      writer.addMatrix("R", 3, 3, rowMajor(poses.back().rotation.matrix()));
      writer.addMatrix("T", 3, 1, rowMajor(poses.back().translation));
    }
  }
  return writer.head + join(writer.nodes, writer.between_nodes) + writer.tail;
}

}  // namespace opencv_format

const CameraFormat& opencv() {
  using namespace opencv_format;
  static const CameraFormat kFormat = {
      .id = "opencv",
      .title = "OpenCV FileStorage (YAML, XML, JSON)",
      .aliases = "cv opencv_yaml filestorage",
      .models = {"pinhole", "radtan", "rational", "thin_prism", "tilted", "kannala_brandt",
                 "kannala_brandt_skew", "omni"},
      .max_cameras = 2,
      .poses = CameraFormat::Poses::kFromFirst,
      .marks = {"camera_matrix", "distortion_coefficients", "dist_coeffs", "intrinsic_matrix"},
      .recognises = recognises,
      .read = read,
      .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
