// SPDX-License-Identifier: MIT
// camodocal's camera (OpenCV's YAML, header %YAML:1.0), which VINS-Mono and VINS-Fusion read too: model_type
// and groups of parameters by name (camodocal/src/camera_models: PinholeCamera.cc, CataCamera.cc,
// EquidistantCamera.cc, ScaramuzzaCamera.cc). KANNALA_BRANDT numbers its coefficients from k2, where we
// number from k1. The rays of scaramuzza have the axes right, down, backward; its inverse polynomial
// approximates the direct one. Pixel (0, 0) is a pixel's centre.
#include <array>
#include <string>

#include <fmt/format.h>

#include "alidade/core/aliases.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/ocam_numbers.h"

namespace alidade::detail::formats {
namespace camodocal_format {

constexpr std::array<LensLayout, 3> kLenses = {
    {{"PINHOLE", "radtan", "k1 k2 p1 p2 fx fy cx cy"},
     {"MEI", "omni", "xi k1 k2 p1 p2 fx fy cx cy"},
     {"KANNALA_BRANDT", "kannala_brandt", "k1 k2 k3 k4 fx fy cx cy"}}};

// The maps with the numbers of a lens, in the layout's order, and the names of these numbers.
struct Group {
  std::string_view lens;
  std::string key;
  std::string_view names;
};
const std::array<Group, 6> kGroups = {
    {{"PINHOLE", "distortion_parameters", "k1 k2 p1 p2"},
     {"PINHOLE", "projection_parameters", "fx fy cx cy"},
     {"MEI", "mirror_parameters", "xi"},
     {"MEI", "distortion_parameters", "k1 k2 p1 p2"},
     {"MEI", "projection_parameters", "gamma1 gamma2 u0 v0"},
     {"KANNALA_BRANDT", "projection_parameters", "k2 k3 k4 k5 mu mv u0 v0"}}};

bool recognises(const CameraDocument& document) {
  return document.has("model_type");
}

constexpr int kMostPowers = 20;

std::vector<std::string> powers(int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.push_back("p" + std::to_string(i));
  return names;
}

StatedCamera readScaramuzza(const YamlNode& root) {
  const YamlNode poly = root.at("poly_parameters");
  const YamlNode affine = root.at("affine_parameters");
  const auto number = [&affine](const char* key) { return statedNumber(affine.at(key)); };
  OcamNumbers numbers = {.polynomial = {},
                         .affine = {number("ac"), number("ad"), number("ae")},
                         .centre = {number("cx"), number("cy")}};
  for (const std::string& name : powers(kMostPowers))
    if (poly.has(name)) numbers.polynomial.push_back(statedNumber(poly.at(name)));
  StatedCamera camera =
      stateOcam(poly.where(), numbers, readSize(root.at("image_width"), root.at("image_height")));
  remarkUnknownKeys(poly, powers(static_cast<int>(numbers.polynomial.size())), camera);
  remarkUnknownKeys(affine, words("ac ad ae cx cy"), camera);
  remarkUnknownKeys(
      root,
      words("model_type camera_name image_width image_height poly_parameters inv_poly_parameters "
            "affine_parameters"),
      camera);
  return camera;
}

CameraSource read(const CameraDocument& document, const ReadOptions&) {
  const YamlNode& root = document.root();
  if (bareWord(root.at("model_type").text()) == "scaramuzza") {
    StatedCamera camera = readScaramuzza(root);
    if (const auto name = root.find("camera_name")) camera.name = name->text();
    return {.cameras = {camera}};
  }
  const LensLayout lens =
      layoutNamed(kLenses, root.at("model_type"),
                  "calibrate with one of these models, in camodocal or with alidade calibrate");
  std::vector<StatedNumber> listed;
  std::vector<std::string> known = {"model_type", "camera_name", "image_width", "image_height"};
  for (const Group& group : kGroups) {
    if (group.lens != lens.name) continue;
    append(listed, numbersOf(root.at(group.key), words(group.names)));
    known.push_back(group.key);
  }
  StatedCamera camera =
      stateCamera(root.at("projection_parameters").where(), lens.model, storageOrder(lens, listed),
                  readSize(root.at("image_width"), root.at("image_height")));
  if (const auto name = root.find("camera_name")) camera.name = name->text();
  for (const Group& group : kGroups) {
    if (group.lens == lens.name) remarkUnknownKeys(root.at(group.key), words(group.names), camera);
  }
  remarkUnknownKeys(root, known, camera);
  return {.cameras = {camera}};
}

std::string write(std::span<const NamedCamera> cameras, const std::string&) {
  const NamedCamera& named = cameras.front();
  const LensLayout& lens = layoutOf(kLenses, named.camera.modelId());
  std::string text = fmt::format(
      "%YAML:1.0\n---\nmodel_type: {}\ncamera_name: {}\nimage_width: {}\nimage_height: {}\n", lens.name,
      yamlText(named.name.empty() ? "camera" : named.name), named.image_size.width, named.image_size.height);
  const std::vector<double> listed = listedOrder(lens, named.camera);
  std::size_t next = 0;
  for (const Group& group : kGroups) {
    if (group.lens != lens.name) continue;
    text += group.key + ":\n";
    for (const std::string& name : words(group.names))
      text += "   " + name + ": " + realText(listed[next++]) + "\n";
  }
  return text;
}

}  // namespace camodocal_format

const CameraFormat& camodocal() {
  using namespace camodocal_format;
  static const CameraFormat kFormat = {
      .id = "camodocal",
      .title = "camodocal camera (YAML)",
      .aliases = "vins vins-mono vins-fusion",
      .models = {"radtan", "omni", "kannala_brandt"},
      .absent = {{"radtan", "k3"}},
      .marks = {"model_type", "projection_parameters", "distortion_parameters", "mirror_parameters"},
      .recognises = recognises,
      .read = read,
      .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
