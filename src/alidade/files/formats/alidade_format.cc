// SPDX-License-Identifier: MIT
// This program's own camera file (docs/files.md).
#include "alidade/files/camera_file.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/nodes.h"

namespace alidade::detail::formats {
namespace alidade_format {

bool recognises(const CameraDocument& document) {
  return document.has("alidade_camera");
}

StatedCameras read(const CameraDocument& document, const ReadOptions&) {
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
                                       .marks = {"alidade_camera"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
