// SPDX-License-Identifier: MIT
#include "alidade/io/camera_source.h"

#include <algorithm>
#include <filesystem>

#include "alidade/core/text.h"
#include "alidade/io/atomic_file.h"
#include "alidade/io/formats/camera_document.h"
#include "alidade/io/formats/camera_format.h"

namespace alidade {
namespace {

constexpr std::size_t kMaxFileBytes = 64U << 20U;

struct PathAndName {
  std::string path;
  std::string name;  // of the camera; empty = none was given
};

// A file whose own name has a # is that file.
PathAndName splitPath(const std::string& text) {
  const std::size_t at = text.rfind('#');
  std::error_code error;
  if (at == std::string::npos || std::filesystem::exists(text, error)) return {text, ""};
  return {text.substr(0, at), text.substr(at + 1)};
}

std::string namesOf(const CameraSource& source) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < source.cameras.size(); ++i) names.push_back(cameraLabel(source, i));
  return join(names, ", ");
}

StatedCamera cameraNamed(const CameraSource& source, const std::string& name) {
  for (const StatedCamera& camera : source.cameras) {
    if (camera.name == name) return camera;
  }
  const auto number = parseInt(name);
  if (number && *number >= 0 && static_cast<std::size_t>(*number) < source.cameras.size())
    return source.cameras[static_cast<std::size_t>(*number)];
  throw inputError({.where = source.path,
                    .found = "no camera '" + name + "'",
                    .expected = "one of " + namesOf(source),
                    .next_step = "write FILE#NAME, or FILE#0 for the first"});
}

void takeSize(StatedCamera& camera, const std::optional<ImageSize>& size, const std::string& where) {
  if (!size) return;
  if (camera.image_size && *camera.image_size != *size) {
    const auto text = [](ImageSize s) { return std::to_string(s.width) + "x" + std::to_string(s.height); };
    throw inputError({.where = where,
                      .found = "an image of " + text(*camera.image_size) + " pixels",
                      .expected = text(*size) + " as --image-size says",
                      .next_step = "leave --image-size away; to change the size: alidade convert --resize"});
  }
  camera.image_size = size;
}

const CameraFormat* formatOf(const detail::CameraDocument& document) {
  for (const CameraFormat* format : cameraFormats()) {
    if (format->recognises(document)) return format;
  }
  return nullptr;
}

std::string titles() {
  std::vector<std::string> names;
  for (const CameraFormat* format : cameraFormats()) names.emplace_back(format->title);
  return join(names, "; ");
}

}  // namespace

CameraSource parseCameras(const std::string& text, const std::string& name, const ReadOptions& options) {
  const detail::CameraDocument document(text, name);
  if (const CameraFormat* format = formatOf(document)) {
    CameraSource source{.path = name,
                        .format = format->id,
                        .format_name = format->title,
                        .cameras = format->read(document, options)};
    if (source.cameras.empty()) {
      throw inputError({.where = name,
                        .found = "no camera in a file of the format " + std::string(format->title),
                        .expected = "at least one"});
    }
    for (StatedCamera& camera : source.cameras) takeSize(camera, options.image_size, name);
    return source;
  }
  const detail::YamlNode& root = document.root();  // says why, where the text is no tree
  throw root.error("nothing that tells the format", "a camera file: " + titles(),
                   "a file of this program starts with: alidade_camera: 1");
}

std::string cameraLabel(const CameraSource& source, std::size_t index) {
  const std::string& name = source.cameras[index].name;
  return name.empty() ? std::to_string(index) : name;
}

std::string cameraFilePath(const std::string& path) {
  return splitPath(path).path;
}

bool isCameraFile(const std::string& path) {
  try {
    return formatOf(detail::CameraDocument(readTextFile(path, kMaxFileBytes), path)) != nullptr;
  } catch (const Error&) {
    return false;
  }
}

CameraSource readCameras(const std::string& path, const ReadOptions& options) {
  const auto [file, name] = splitPath(path);
  CameraSource source = parseCameras(readTextFile(file, kMaxFileBytes), file, options);
  if (!name.empty()) source.cameras = {cameraNamed(source, name)};
  return source;
}

CameraFile cameraFileOf(const StatedCamera& camera, const std::string& where) {
  if (camera.own) return *camera.own;
  if (!camera.image_size) {
    throw inputError(
        {.where = where,
         .found = "no size of the image",
         .expected = "a file that states it, or --image-size",
         .next_step =
             "add --image-size WIDTHxHEIGHT, the size of the images in pixels (to alidade convert, where a "
             "command has no such flag)"});
  }
  return {.camera = camera.camera,
          .image_size = *camera.image_size,
          .domain = {},
          .self_check = {},
          .calibration = {},
          .created_by = {}};
}

CameraFile readCamera(const std::string& path, const ReadOptions& options) {
  const CameraSource source = readCameras(path, options);
  if (source.cameras.size() > 1) {
    throw inputError({.where = source.path,
                      .found = std::to_string(source.cameras.size()) + " cameras: " + namesOf(source),
                      .expected = "one camera",
                      .next_step = "name one: " + source.path + "#" + cameraLabel(source, 0)});
  }
  return cameraFileOf(source.cameras.front(), source.path);
}

}  // namespace alidade
