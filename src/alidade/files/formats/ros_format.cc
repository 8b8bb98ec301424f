// SPDX-License-Identifier: MIT
// ROS camera_info as YAML: the file of the package camera_calibration_parsers, and the message itself (D, K,
// R, P) as `rostopic echo` and `ros2 topic echo` print it. The models are those of sensor_msgs/CameraInfo:
// plumb_bob (5), rational_polynomial (8), equidistant (4, also called fisheye). Pixel (0, 0) is a pixel's
// centre. A file may hold the messages of several cameras in a list or a map. RealSense's driver uses its own
// names (realsense-ros, and librealsense's rs2_distortion_to_string): None, and Inverse Brown Conrady, whose
// coefficients map image directions to those of the lens.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "alidade/camera/camera_edit.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/pose_numbers.h"
#include "alidade/files/formats/small_format.h"

namespace alidade::detail::formats {
namespace ros_format {

// The names in the file, in ROS 1's message, and in ROS 2's message.
struct Names {
  const char* width;
  const char* height;
  const char* matrix;
  const char* coefficients;
  const char* projection;
  const char* rectification;
};
constexpr std::array<Names, 3> kNames = {
    {{"image_width", "image_height", "camera_matrix", "distortion_coefficients", "projection_matrix",
      "rectification_matrix"},
     {"width", "height", "K", "D", "P", "R"},
     {"width", "height", "k", "d", "p", "r"}}};
const std::vector<std::string> kKnown = words(
    "image_width image_height camera_name camera_matrix distortion_model distortion_coefficients "
    "rectification_matrix projection_matrix header width height K D R P k d r p binning_x binning_y roi");

// The models of sensor_msgs/CameraInfo, and their coefficients.
constexpr std::array<LensLayout, 5> kDistortions = {
    {{"plumb_bob", "radtan", "k1 k2 p1 p2 k3"},
     {"rational_polynomial", "rational", "k1 k2 p1 p2 k3 k4 k5 k6"},
     {"equidistant", "kannala_brandt", "k1 k2 k3 k4"},
     {"fisheye", "kannala_brandt", "k1 k2 k3 k4"},
     {"Inverse Brown Conrady", "inverse_brown", "k1 k2 p1 p2 k3"}}};

const Names* namesOf(const YamlNode& message) {
  for (const Names& names : kNames) {
    if (message.has(names.matrix)) return &names;
  }
  return nullptr;
}

bool isMessage(const YamlNode& node) {
  const Names* const names = namesOf(node);
  // Old calibrators did not name the model.
  return names != nullptr &&
         (node.has("distortion_model") || (node.has(names->rectification) && node.has(names->projection)));
}

// The message that the file is, or those that it holds in a list or a map, or one level below.
std::vector<SmallPlace> messagesOf(const YamlNode& root) {
  if (isMessage(root)) return {{"", root}};
  std::vector<SmallPlace> all =
      placesOf({.id = "ros", .title = "", .marks = "", .cameras = "* *.*", .lenses = {}}, root);
  std::erase_if(all, [&root](const SmallPlace& place) {
    return root.has("intrinsics") || !place.map.has("distortion_model") || !isMessage(place.map);
  });
  return all;
}

bool recognises(const CameraDocument& document) {
  const std::string& text = document.text();
  if (!document.isTree() || text.find("opencv-matrix") != std::string::npos ||
      text.find("opencv_storage") != std::string::npos)
    return false;
  try {
    return !messagesOf(document.root()).empty();
  } catch (const Error&) {
    return false;  // too many, or a key that is no text
  }
}

// Refuses a file of one kind with a key of another, because either may be meant.
void refuseMixedNames(const YamlNode& root, const Names& names) {
  for (const Names& other : kNames) {
    for (const auto member : {&Names::width, &Names::height, &Names::matrix, &Names::coefficients,
                              &Names::projection, &Names::rectification}) {
      const std::string own = names.*member;
      const std::string foreign = other.*member;
      const auto theirs = root.find(foreign);
      if (own == foreign || !theirs || theirs->isNull()) continue;
      const auto ours = root.find(own);
      const auto numbers = [](const YamlNode& node) {
        return node.isScalar() ? std::vector<StatedNumber>{statedNumber(node)} : statedNumbers(node);
      };
      if (ours && isSameStated(numbers(*ours), numbers(*theirs))) continue;
      if (ours) {
        throw theirs->error("'" + foreign + "', which differs from '" + own + "' at " + ours->where(),
                            "only one of them, or equal values", "remove the wrong one");
      }
      throw theirs->error("'" + foreign + "' and '" + names.matrix + "', which belong to two kinds of files",
                          "'" + own + "' and '" + names.matrix + "'",
                          "rename it, or remove it if it is something else");
    }
  }
}

// The size of the image. Drivers that do not know it write 0; the user's size is then used, with a remark.
ImageSize sizeOf(const YamlNode& root, const Names& names, const ReadOptions& options,
                 std::vector<Remark>& remarks) {
  const ImageSize given = options.image_size.value_or(ImageSize{});
  std::string unknown;
  for (const auto& [key, side] :
       {std::pair(names.width, given.width), std::pair(names.height, given.height)}) {
    const auto node = root.find(key);
    const bool is_stated = node && !node->isNull() && node->number() != 0;
    if (!options.image_size) {
      if (is_stated) continue;
      if (!node) {
        throw root.error(std::string("no key '") + key + "'", "the image size in pixels",
                         "add it, or --image-size WIDTHxHEIGHT");
      }
      throw node->error(node->isNull() ? "nothing" : "'" + node->text() + "'", "1 to 1000000 pixels",
                        "correct it, or add --image-size WIDTHxHEIGHT");
    }
    if (!is_stated) {
      unknown += (unknown.empty() ? "" : " and ") + std::string(key);
    } else if (node->number() != side) {
      throw node->error("'" + node->text() + "'", std::to_string(side) + " from --image-size",
                        "correct one of them");
    }
  }
  if (unknown.empty()) return readSize(root.at(names.width), root.at(names.height));
  remarks.push_back({"assumed", root.where() + ": " + unknown + " missing or 0; assumed to be " +
                                    sizeText(given) + " from --image-size"});
  return given;
}

// The projection matrix belongs to the rectified image, which has a different camera.
void remarkProjection(const YamlNode& root, const char* key, std::span<const StatedNumber> pinhole,
                      StatedCamera& camera) {
  const auto node = root.find(key);
  if (!node || node->isNull()) return;
  const std::vector<StatedNumber> P = statedNumbers(*node, 12);
  if (areZero(P)) return;
  if (P[2].value > 0 && P[6].value > 0) camera.rectified_center = Eigen::Vector2d(P[2].value, P[6].value);
  if (P[0].value > 0 && P[5].value > 0) camera.rectified_focal = Eigen::Vector2d(P[0].value, P[5].value);
  constexpr std::array<std::size_t, 9> kLeft = {0, 1, 2, 4, 5, 6, 8, 9, 10};
  const StatedNumber zero;
  const StatedNumber one{1, 0};
  const std::array<StatedNumber, 9> K = {pinhole[0], zero, pinhole[2], zero, pinhole[1],
                                         pinhole[3], zero, zero,       one};
  for (std::size_t i = 0; i < K.size(); ++i) {
    if (isSameStated(P[kLeft[i]], K[i])) continue;
    camera.remarks.push_back(
        {"not_carried", root.whereKey(key) + ": this is the camera of the rectified images; it differs from "
                                             "the camera matrix and is ignored"});
    return;
  }
}

// The images of a topic: a part of the whole image, in which binning combines pixels.
struct TopicImages {
  PixelRect part;
  int columns = 1;  // combined into one
  int rows = 1;
  std::string key = {};  // that states it; empty: these are whole images
};

TopicImages readTopicImages(const YamlNode& root, ImageSize size) {
  TopicImages images{.part = {.width = size.width, .height = size.height}};
  for (auto [key, factor] : {std::pair("binning_y", &images.rows), std::pair("binning_x", &images.columns)}) {
    const auto node = root.find(key);
    if (!node || node->isNull()) continue;
    *factor = std::max(1, node->integer());
    if (*factor > 1) images.key = key;
  }
  const auto roi = root.find("roi");
  if (!roi || !roi->isMap()) return images;
  const auto stated = [&roi](const char* key) {
    return roi->has(key) ? std::clamp(roi->at(key).integer(), -1, kMaxImageSide) : 0;
  };
  PixelRect part{
      .x = stated("x_offset"), .y = stated("y_offset"), .width = stated("width"), .height = stated("height")};
  if (part.width == 0) part.width = size.width - part.x;  // 0: up to the edge
  if (part.height == 0) part.height = size.height - part.y;
  if (part.x == 0 && part.y == 0 && part.width == size.width && part.height == size.height) return images;
  images.part = part;
  images.key = "roi";
  return images;
}

// The camera of a part of the image; the size is divided by the numbers of pixels that binning combines.
EditedCamera cameraOfPart(const AnyCamera& camera, ImageSize size, const TopicImages& images) {
  PixelRect part = images.part;
  part.width -= part.width % images.columns;
  part.height -= part.height % images.rows;
  const EditedCamera cropped = cropCamera(camera, size, part);
  return resizeCamera(cropped.camera, cropped.size,
                      {.width = part.width / images.columns, .height = part.height / images.rows});
}

// K and P belong to the whole image; the images of the topic may be a part of it.
void takeImagePart(const YamlNode& root, const ReadOptions& options, StatedCamera& camera) {
  const ImageSize size = camera.image_size.value();
  const TopicImages images = readTopicImages(root, size);
  if (images.key.empty()) return;
  std::string text = root.whereKey(images.key) + ": K is of " + sizeText(size) + "; ";
  text += images.key == "roi" ? fmt::format("this image is its part at x {}, y {} of {}x{}", images.part.x,
                                            images.part.y, images.part.width, images.part.height)
                              : "this image has all of it";
  const bool is_binned = images.columns > 1 || images.rows > 1;
  if (is_binned)
    text += fmt::format(", {}x{} pixels combined into one: {}x{}", images.columns, images.rows,
                        images.part.width / images.columns, images.part.height / images.rows);
  if (!options.applies_roi) {
    camera.remarks.push_back(
        {"not_carried",
         text + ". The camera that was read is of the whole image; --apply-roi reads that of the part"});
    return;
  }
  const EditedCamera part =
      withPlace(root.whereKey(images.key), [&] { return cameraOfPart(camera.camera, size, images); });
  if (is_binned) {
    text += fmt::format(". Where a driver skips pixels instead, cx is {:g} and cy {:g} px larger",
                        0.5 - 0.5 / images.columns, 0.5 - 0.5 / images.rows);
  }
  camera.remarks.push_back({"assumed", text});
  if (camera.rectified_center && camera.rectified_focal) {
    const AnyCamera rectified =
        AnyCamera::make("pinhole", std::array{camera.rectified_focal->x(), camera.rectified_focal->y(),
                                              camera.rectified_center->x(), camera.rectified_center->y()});
    const AnyCamera rectified_part = cameraOfPart(rectified, size, images).camera;
    const auto p = rectified_part.parameters();
    camera.rectified_focal = Eigen::Vector2d(p[0], p[1]);
    camera.rectified_center = Eigen::Vector2d(p[2], p[3]);
  }
  camera.camera = part.camera;
  camera.image_size = part.size;
}

// The model that image_geometry applies, which goes by the number of coefficients. A driver may write a
// longer list of zeros under plumb_bob.
std::string_view readPerspective(const YamlNode& place, const std::string& name,
                                 std::vector<StatedNumber>& coefficients) {
  constexpr std::size_t kPlumbBob = 5;
  const std::size_t count = coefficients.size();
  if (name == "plumb_bob" && count > kPlumbBob) {
    if (!areZero(std::span(coefficients).subspan(kPlumbBob))) {
      throw place.error(
          std::to_string(count) + " coefficients for plumb_bob, of which those after the fifth are not zero",
          "plumb_bob with 5 (radtan), or rational_polynomial, as image_geometry reads " +
              std::to_string(count),
          "write the model that the calibration used: distortion_model: rational_polynomial, or only 5 coefficients");
    }
    coefficients.resize(kPlumbBob);
  }
  return modelOfCoefficients(place, coefficients);
}

// Alidade's name of the distortion model in a file, and the number of its coefficients.
std::string_view readDistortion(const YamlNode& root, const YamlNode& place,
                                std::vector<StatedNumber>& coefficients, std::vector<Remark>& remarks) {
  const auto stated_name = root.find("distortion_model");
  const YamlNode name = stated_name.value_or(place);
  const std::string usual = coefficients.size() == 8 ? "rational_polynomial" : "plumb_bob";
  const std::string stated = !stated_name ? usual : name.isNull() ? "" : name.text();
  if (!stated_name)
    remarks.push_back({"assumed", place.where() + ": no distortion_model; assumed to be " + usual});
  const bool is_zero = areZero(coefficients);
  if (stated.empty() || stated == "none" || stated == "None") {
    if (!is_zero) {
      throw name.error(
          "no distortion model",
          "a model, because the coefficients are not zero: plumb_bob, rational_polynomial or equidistant",
          "write the model that the driver or the calibration used");
    }
    coefficients.clear();
    return "pinhole";
  }
  if (stated == "plumb_bob" || stated == "rational_polynomial")
    return readPerspective(place, stated, coefficients);
  if (const LensLayout* lens = findLayout(kDistortions, stated)) {
    const std::size_t count = words(lens->order).size();
    if (coefficients.size() == count) return lens->model;
    throw place.error(std::to_string(coefficients.size()) + " coefficients",
                      std::to_string(count) + " for " + stated, "correct distortion_model, or the list");
  }
  const std::vector<std::string> known = {"plumb_bob", "rational_polynomial", "equidistant"};
  throw name.error(
      "'" + stated + "'", "plumb_bob, rational_polynomial or equidistant",
      is_zero ? "all coefficients are 0: write plumb_bob, which is the same lens"
              : didYouMean(stated, known,
                           "calibrate the camera again with alidade calibrate or ROS camera_calibration"));
}

StatedCamera readMessage(const YamlNode& root, const ReadOptions& options) {
  const Names* const stated = namesOf(root);
  const Names& names = stated == nullptr ? kNames.front() : *stated;
  refuseMixedNames(root, names);
  const YamlNode matrix = root.at(names.matrix);
  StatedNumber skew;
  std::vector<StatedNumber> parameters = readCameraMatrix(matrix, &skew);
  const auto coefficients_node = root.find(names.coefficients);
  std::vector<StatedNumber> coefficients;
  if (coefficients_node && !coefficients_node->isNull()) coefficients = statedNumbers(*coefficients_node);
  const YamlNode place = coefficients_node.value_or(matrix);
  std::vector<Remark> remarks;
  const std::string_view distortion = readDistortion(root, place, coefficients, remarks);
  const std::vector<StatedNumber> pinhole = parameters;
  append(parameters, coefficients);
  const std::string_view model = takeSkew(matrix, distortion, skew, parameters);
  const ImageSize size = sizeOf(root, names, options, remarks);
  StatedCamera camera = stateCamera(place.where(), model, parameters, size, remarks);
  remarkUnknownKeys(root, kKnown, camera);
  remarkProjection(root, names.projection, pinhole, camera);
  takeImagePart(root, options, camera);
  return camera;
}

CameraSource read(const CameraDocument& document, const ReadOptions& options) {
  std::vector<SmallPlace> messages = messagesOf(document.root());
  if (messages.empty()) messages.push_back({"", document.root()});  // readMessage() says what it lacks
  CameraSource all;
  for (const SmallPlace& message : messages) {
    const auto name = message.map.find("camera_name");
    all.add(name && !name->isNull() ? name->text() : message.name,
            [&] { return readMessage(message.map, options); });
  }
  for (StatedCamera& camera : all.cameras) {
    const YamlNode& message = messages[camera.number].map;
    const Names& names = *namesOf(message);
    // Several cameras may be those of several pairs, each with a rectified frame of its own.
    const bool is_alone = messages.size() == 1;
    if (is_alone) {
      statePoses(all, [&](std::vector<Remark>& told) {
        const auto pose = readRectification(message, names.rectification, names.projection, told);
        return pose ? std::vector<SE3>{*pose} : std::vector<SE3>();
      });
    }
    if (!camera.camera_from_rig)
      remarkNotCarried(message, {names.rectification, is_alone ? "" : names.projection}, camera);
  }
  return all;
}

std::string matrixText(const std::string& key, int rows, int columns, std::span<const double> values) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: {}\n", key, rows, columns, listText(values));
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  const NamedCamera& named = cameras.front();
  const std::span<const double> p = named.camera.parameters();
  const std::string_view model = named.camera.modelId();
  std::vector<double> coefficients(p.begin() + 4, p.end());
  if (model == "pinhole") coefficients.assign(5, 0.0);
  // A pinhole is written as plumb_bob with zeros.
  const std::string_view ros_model = model == "pinhole" ? "plumb_bob" : layoutOf(kDistortions, model).name;
  const std::array<double, 9> K = {p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1};
  std::vector<double> R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::vector<double> P = {p[0], 0, p[2], 0, 0, p[1], p[3], 0, 0, 0, 1, 0};
  if (named.rectified) {
    R = rowMajor(named.rectified->rectified_from_camera.matrix());
    P = rowMajor(named.rectified->pixel_from_first);
  }
  return fmt::format(
      "image_width: {}\nimage_height: {}\ncamera_name: {}\n{}distortion_model: {}\n{}{}{}",
      named.image_size.width, named.image_size.height, yamlText(named.name.empty() ? "camera" : named.name),
      matrixText("camera_matrix", 3, 3, K), ros_model,
      matrixText("distortion_coefficients", 1, static_cast<int>(coefficients.size()), coefficients),
      matrixText("rectification_matrix", 3, 3, R), matrixText("projection_matrix", 3, 4, P));
}

}  // namespace ros_format

const CameraFormat& ros() {
  using namespace ros_format;
  static const CameraFormat kFormat = {
      .id = "ros",
      .title = "ROS camera_info (YAML)",
      .aliases = "ros2 camera_info ros_yaml",
      .models = {"pinhole", "radtan", "rational", "kannala_brandt"},
      .holds_rectification = true,
      .max_read = CameraFormat::kAnyNumber,
      .holds_part = true,
      .marks = {"camera_matrix", "distortion_model", "distortion_coefficients", "projection_matrix"},
      .recognises = recognises,
      .read = read,
      .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
