// SPDX-License-Identifier: MIT
// Alidade's own camera file (docs/files.md).
#include "alidade/files/formats/alidade_reader.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade::detail::formats {
namespace alidade_format {

bool recognises(const CameraDocument& document) {
  return document.has("alidade_camera") || document.has("alidade_rig");
}

// The cameras of a rig file.
StatedCameras readRig(const YamlNode& root, const ReadOptions& options) {
  checkRigRoot(root);
  StatedCameras cameras{.readRigRest = [root](RigRecord& rig) { readRigRest(root, rig); }};
  for (const YamlNode& entry : root.at("cameras").items()) {
    const std::string name = entry.at("name").text();
    if (!options.only.empty() && options.only != name) {
      cameras.passed.push_back(name);
      continue;
    }
    cameras.add(name, [&] {
      RigCameraRecord record = readRigCamera(entry);
      return StatedCamera{.name = name,
                          .camera = record.camera.camera,
                          .image_size = record.camera.image_size,
                          .camera_from_rig = record.camera_from_rig,
                          .own = std::move(record.camera)};
    });
  }
  return cameras;
}

StatedCameras read(const CameraDocument& document, const ReadOptions& options) {
  if (document.has("alidade_rig")) return readRig(document.root(), options);
  CameraRecord file = readCameraRoot(document.root());
  return {.cameras = {{.camera = file.camera, .image_size = file.image_size, .own = std::move(file)}}};
}

// Several cameras make a rig. How it was calibrated is unknown here.
std::string write(std::span<const NamedCamera> cameras) {
  if (cameras.size() > 1) {
    const std::vector<SE3> poses = posesOf(cameras);
    if (poses.empty()) {
      throw inputError({.where = cameras.front().where,
                        .found = std::to_string(cameras.size()) + " cameras without poses",
                        .expected = "one camera, or cameras with poses, which are a rig",
                        .next_step = "select a camera with FILE#NAME"});
    }
    RigRecord rig;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      rig.cameras.push_back(
          {.camera = bareRecord(cameras[i].camera, cameras[i].image_size, ""), .camera_from_rig = poses[i]});
      rig.cameras.back().camera.name.name = cameras[i].name.empty() ? std::to_string(i) : cameras[i].name;
    }
    return rigFileText(rig);
  }
  return cameraFileText(bareRecord(cameras.front().camera, cameras.front().image_size, ""));
}

}  // namespace alidade_format

const CameraFormat& alidade() {
  using namespace alidade_format;
  static const CameraFormat kFormat = {.id = "alidade",
                                       .title = "Alidade camera file (YAML)",
                                       .models = {modelIds().begin(), modelIds().end()},
                                       .max_cameras = CameraFormat::kAnyNumber,
                                       .poses = CameraFormat::Poses::kFromRig,
                                       .marks = {"alidade_camera", "alidade_rig"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
