// SPDX-License-Identifier: MIT
// camodocal's camera (OpenCV's YAML, header %YAML:1.0), which VINS-Mono and VINS-Fusion read too: model_type
// and groups of parameters by name (camodocal/src/camera_models: PinholeCamera.cc, CataCamera.cc,
// EquidistantCamera.cc). KANNALA_BRANDT numbers its coefficients from k2, where we number from k1. Pixel (0,
// 0) is a pixel's centre.
#include <algorithm>
#include <array>
#include <string>

#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/format_text.h"
#include "alidade/files/formats/formats.h"
#include "alidade/files/formats/lens_layout.h"

namespace alidade::formats {
namespace {

using detail::CameraDocument;
using detail::LensLayout;
using detail::StatedNumber;
using detail::YamlNode;

struct Group {
  const char* key;
  std::vector<std::string> names;  // theirs
};

struct Lens {
  LensLayout layout;
  std::vector<Group> groups;  // in the layout's order
};

const std::vector<Lens>& lenses() {
  static const std::vector<Lens> kLenses = {
      {.layout = {"PINHOLE", "radtan", "k1 k2 p1 p2 fx fy cx cy"},
       .groups = {{"distortion_parameters", {"k1", "k2", "p1", "p2"}},
                  {"projection_parameters", {"fx", "fy", "cx", "cy"}}}},
      {.layout = {"MEI", "omni", "xi k1 k2 p1 p2 fx fy cx cy"},
       .groups = {{"mirror_parameters", {"xi"}},
                  {"distortion_parameters", {"k1", "k2", "p1", "p2"}},
                  {"projection_parameters", {"gamma1", "gamma2", "u0", "v0"}}}},
      {.layout = {"KANNALA_BRANDT", "kannala_brandt", "k1 k2 k3 k4 fx fy cx cy"},
       .groups = {{"projection_parameters", {"k2", "k3", "k4", "k5", "mu", "mv", "u0", "v0"}}}}};
  return kLenses;
}

bool recognises(const CameraDocument& document) {
  return document.has("model_type");
}

const Lens& lensOf(const YamlNode& type) {
  std::vector<std::string> names;
  for (const Lens& lens : lenses()) {
    if (type.text() == lens.layout.name) return lens;
    names.emplace_back(lens.layout.name);
  }
  throw type.error("'" + type.text() + "'", join(names, ", "),
                   didYouMean(type.text(), names,
                              "calibrate with one of these models, in camodocal or with alidade calibrate"));
}

StatedCameras read(const CameraDocument& document, const ReadOptions&) {
  const YamlNode& root = document.root();
  const Lens& lens = lensOf(root.at("model_type"));
  std::vector<StatedNumber> listed;
  for (const Group& group : lens.groups)
    detail::append(listed, detail::numbersOf(root.at(group.key), group.names));
  const auto name = root.find("camera_name");
  StatedCamera camera =
      detail::stateCamera(root.at(lens.groups.back().key).where(), name ? name->text() : "",
                          lens.layout.model, detail::storageOrder(lens.layout, listed),
                          detail::readSize(root.at("image_width"), root.at("image_height")));
  std::vector<std::string> known = {"model_type", "camera_name", "image_width", "image_height"};
  for (const Group& group : lens.groups) {
    known.emplace_back(group.key);
    detail::remarkUnknownKeys(root.at(group.key), group.names, camera);
  }
  detail::remarkUnknownKeys(root, known, camera);
  return {.cameras = {camera}};
}

std::string write(std::span<const NamedCamera> cameras) {
  const NamedCamera& named = cameras.front();
  const auto lens = std::find_if(lenses().begin(), lenses().end(), [&named](const Lens& candidate) {
    return candidate.layout.model == named.camera.modelId();
  });
  expect(lens != lenses().end(), "the format has a lens for each of its models");
  std::string text = "%YAML:1.0\n---\nmodel_type: " + std::string(lens->layout.name) +
                     "\ncamera_name: " + detail::yamlText(named.name.empty() ? "camera" : named.name) +
                     "\nimage_width: " + std::to_string(named.image_size.width) +
                     "\nimage_height: " + std::to_string(named.image_size.height) + "\n";
  const std::vector<double> listed = detail::listedOrder(lens->layout, named.camera);
  std::size_t next = 0;
  for (const Group& group : lens->groups) {
    text += std::string(group.key) + ":\n";
    for (const std::string& name : group.names)
      text += "   " + name + ": " + detail::realText(listed[next++]) + "\n";
  }
  return text;
}

}  // namespace

const CameraFormat& camodocal() {
  static const CameraFormat kFormat = {
      .id = "camodocal",
      .title = "camodocal camera (YAML)",
      .models = {"radtan", "omni", "kannala_brandt"},
      .absent = {{"radtan", "k3"}},
      .marks = {"model_type", "projection_parameters", "distortion_parameters", "mirror_parameters"},
      .recognises = recognises,
      .read = read,
      .write = write};
  return kFormat;
}

}  // namespace alidade::formats
