// SPDX-License-Identifier: MIT
// This program's own camera file (docs/files.md).
#include <algorithm>

#include "alidade/camera/self_check.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/camera_node.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/formats.h"

namespace alidade::formats {
namespace {

bool recognises(const detail::CameraDocument& document) {
  return document.has("alidade_camera");
}

StatedCameras read(const detail::CameraDocument& document, const ReadOptions&) {
  CameraRecord file = detail::readCameraRoot(document.root(), document.treeText());
  StatedCamera camera{.name = "",
                      .number = 0,
                      .camera = file.camera,
                      .image_size = file.image_size,
                      .remarks = {},
                      .own = std::move(file)};
  return {.cameras = {camera}};
}

std::string write(std::span<const NamedCamera> cameras) {
  return cameraFileText(bareRecord(cameras.front().camera, cameras.front().image_size, ""));
}

}  // namespace

const CameraFormat& alidade() {
  static const CameraFormat kFormat = {.id = "alidade",
                                       .title = "Alidade camera file (YAML)",
                                       .models = {modelIds().begin(), modelIds().end()},
                                       .marks = {"alidade_camera"},
                                       .recognises = recognises,
                                       .read = read,
                                       .write = write};
  return kFormat;
}

}  // namespace alidade::formats
