// SPDX-License-Identifier: MIT
// This program's own camera file (docs/files.md).
#include "alidade/files/camera_file.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/nodes.h"

namespace alidade::detail::formats {
namespace alidade_format {

bool recognises(const CameraDocument& document) {
  return document.has("alidade_camera") || document.has("alidade_rig");
}

// The cameras of a rig file.
StatedCameras readRig(const YamlNode& root, const ReadOptions& options) {
  root.allowKeys({"alidade_rig", "conventions", "cameras", "calibration", "created_by"});
  const YamlNode version = root.at("alidade_rig");
  if (version.integer() != 1) throw version.error("version " + version.text(), "version 1");
  StatedCameras cameras;
  for (const YamlNode& entry : root.at("cameras").items()) {
    entry.allowKeys({"name", "camera_from_rig", "camera_from_rig_std", "camera"});
    const std::string name = entry.at("name").text();
    static_cast<void>(readPose(entry.at("camera_from_rig")));  // a damaged file is refused as a whole
    if (!options.only.empty() && options.only != name) {
      cameras.passed.push_back(name);
      continue;
    }
    cameras.add(name, [&] {
      CameraRecord record = readCameraRoot(entry.at("camera"));
      return StatedCamera{
          .name = name, .camera = record.camera, .image_size = record.image_size, .own = std::move(record)};
    });
  }
  return cameras;
}

StatedCameras read(const CameraDocument& document, const ReadOptions& options) {
  if (document.has("alidade_rig")) return readRig(document.root(), options);
  CameraRecord file = readCameraRoot(document.root());
  return {.cameras = {{.camera = file.camera, .image_size = file.image_size, .own = std::move(file)}}};
}

std::string write(std::span<const NamedCamera> cameras) {
  return cameraFileText(bareRecord(cameras.front().camera, cameras.front().image_size, ""));
}

}  // namespace alidade_format

const CameraFormat& alidade() {
  using namespace alidade_format;
  static const CameraFormat kFormat = {.id = "alidade",
                                       .title = "Alidade camera file (YAML)",
                                       .models = {modelIds().begin(), modelIds().end()},
                                       .marks = {"alidade_camera", "alidade_rig"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
