// SPDX-License-Identifier: MIT
// ROS camera_info as YAML: the file of the package camera_calibration_parsers, and the message itself (D, K,
// R, P) as `rostopic echo` and `ros2 topic echo` print it. The models are those of sensor_msgs/CameraInfo:
// plumb_bob (5), rational_polynomial (8), equidistant (4, also called fisheye). Pixel (0, 0) is a pixel's
// centre.
#include <array>
#include <string>

#include "alidade/core/text.h"
#include "alidade/io/formats/camera_document.h"
#include "alidade/io/formats/format_text.h"
#include "alidade/io/formats/formats.h"
#include "alidade/io/formats/lens_numbers.h"

namespace alidade::formats {
namespace {

using detail::CameraDocument;
using detail::StatedNumber;
using detail::YamlNode;

// The names of the file, of ROS 1's message, of ROS 2's message.
struct Names {
  const char* width;
  const char* height;
  const char* matrix;
  const char* coefficients;
};
constexpr std::array<Names, 3> kNames = {
    {{"image_width", "image_height", "camera_matrix", "distortion_coefficients"},
     {"width", "height", "K", "D"},
     {"width", "height", "k", "d"}}};
const std::vector<std::string> kKnown = {"image_width",
                                         "image_height",
                                         "camera_name",
                                         "camera_matrix",
                                         "distortion_model",
                                         "distortion_coefficients",
                                         "rectification_matrix",
                                         "projection_matrix",
                                         "header",
                                         "width",
                                         "height",
                                         "K",
                                         "D",
                                         "R",
                                         "P",
                                         "k",
                                         "d",
                                         "r",
                                         "p",
                                         "binning_x",
                                         "binning_y",
                                         "roi"};

const Names* namesOf(const CameraDocument& document) {
  for (const Names& names : kNames) {
    if (document.has(names.matrix)) return &names;
  }
  return nullptr;
}

bool recognises(const CameraDocument& document) {
  const std::string& text = document.text();
  return document.has("distortion_model") && namesOf(document) != nullptr &&
         text.find("opencv-matrix") == std::string::npos && text.find("opencv_storage") == std::string::npos;
}

// Images of a topic may be binned and cut; the camera is that of the whole sensor.
void remarkCroppedImages(const YamlNode& root, StatedCamera& camera) {
  const auto above = [](const YamlNode& map, const char* key, double limit) {
    const auto node = map.find(key);
    return node && node->number() > limit;
  };
  const auto roi = root.find("roi");
  const bool is_cut = roi && roi->isMap() && (above(*roi, "width", 0) || above(*roi, "height", 0));
  if (!is_cut && !above(root, "binning_x", 1) && !above(root, "binning_y", 1)) return;
  camera.remarks.push_back(
      {"not_carried", root.where() +
                          ": binning and roi are not carried along: this is the camera of "
                          "the whole image; alidade convert --crop and --bin make that of the part"});
}

std::vector<StatedCamera> read(const CameraDocument& document, const ReadOptions&) {
  const YamlNode& root = document.root();
  const Names& names = *namesOf(document);
  const YamlNode matrix = root.at(names.matrix);
  std::vector<StatedNumber> parameters = detail::readCameraMatrix(matrix);
  const YamlNode model_node = root.at("distortion_model");
  const std::string stated = model_node.isNull() ? "" : model_node.text();
  const auto coefficients_node = root.find(names.coefficients);
  std::vector<StatedNumber> coefficients;
  if (coefficients_node) coefficients = detail::statedNumbers(*coefficients_node);
  const std::size_t count = coefficients.size();
  const YamlNode place = coefficients_node.value_or(matrix);
  const auto wrongCount = [&](const char* expected) {
    return place.error(std::to_string(count) + " coefficients", std::string(expected) + " for " + stated);
  };
  std::string model;
  if (stated == "plumb_bob") {
    if (count != 4 && count != 5) throw wrongCount("5");
    coefficients.resize(5);
    model = "radtan";
  } else if (stated == "rational_polynomial") {
    if (count != 8) throw wrongCount("8");
    model = "rational";
  } else if (stated == "equidistant" || stated == "fisheye") {
    if (count != 4) throw wrongCount("4");
    model = "kannala_brandt";
  } else if (stated.empty() || stated == "none") {
    for (const StatedNumber& number : coefficients) {
      if (number.value != 0)
        throw model_node.error("no distortion model",
                               "one, as the coefficients are not zero: plumb_bob, "
                               "rational_polynomial or equidistant");
    }
    coefficients.clear();
    model = "pinhole";
  } else {
    throw model_node.error("'" + stated + "'", "plumb_bob, rational_polynomial or equidistant");
  }
  detail::append(parameters, coefficients);
  const auto name = root.find("camera_name");
  StatedCamera camera =
      detail::stateCamera(place.where(), name && !name->isNull() ? name->text() : "", model, parameters,
                          detail::readSize(root.at(names.width), root.at(names.height)));
  detail::remarkUnknownKeys(root, kKnown, camera);
  detail::remarkNotCarried(root, {"rectification_matrix", "R", "r"}, camera);
  remarkCroppedImages(root, camera);
  return {camera};
}

std::string matrixText(const std::string& key, int rows, int columns, std::span<const double> values) {
  return key + ":\n  rows: " + std::to_string(rows) + "\n  cols: " + std::to_string(columns) +
         "\n  data: " + detail::listText(values) + "\n";
}

std::string write(std::span<const NamedCamera> cameras) {
  const NamedCamera& named = cameras.front();
  const std::span<const double> p = named.camera.parameters();
  const std::string_view model = named.camera.modelId();
  std::vector<double> coefficients(p.begin() + 4, p.end());
  if (model == "pinhole") coefficients.assign(5, 0.0);
  const std::string ros_model = model == "rational"         ? "rational_polynomial"
                                : model == "kannala_brandt" ? "equidistant"
                                                            : "plumb_bob";
  const std::array<double, 9> K = {p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1};
  const std::array<double, 9> R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::array<double, 12> P = {p[0], 0, p[2], 0, 0, p[1], p[3], 0, 0, 0, 1, 0};
  return "image_width: " + std::to_string(named.image_size.width) +
         "\nimage_height: " + std::to_string(named.image_size.height) +
         "\ncamera_name: " + detail::yamlText(named.name.empty() ? "camera" : named.name) + "\n" +
         matrixText("camera_matrix", 3, 3, K) + "distortion_model: " + ros_model + "\n" +
         matrixText("distortion_coefficients", 1, static_cast<int>(coefficients.size()), coefficients) +
         matrixText("rectification_matrix", 3, 3, R) + matrixText("projection_matrix", 3, 4, P);
}

}  // namespace

const CameraFormat& ros() {
  static const CameraFormat kFormat = {.id = "ros",
                                       .title = "ROS camera_info (YAML)",
                                       .models = {"pinhole", "radtan", "rational", "kannala_brandt"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::formats
