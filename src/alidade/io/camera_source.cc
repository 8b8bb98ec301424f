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

bool isNumber(const std::string& name) {
  return !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
}

StatedCamera cameraNamed(const CameraSource& source, const std::string& name) {
  for (const StatedCamera& camera : source.cameras) {
    if (camera.name == name) return camera;
  }
  // Where names are numbers, as in COLMAP, another number is a mistake and no place in the list.
  const bool has_numbers = std::any_of(source.cameras.begin(), source.cameras.end(),
                                       [](const StatedCamera& c) { return isNumber(c.name); });
  const auto number = isNumber(name) && !has_numbers ? parseInt(name) : std::nullopt;
  if (number && static_cast<std::size_t>(*number) < source.cameras.size())
    return source.cameras[static_cast<std::size_t>(*number)];
  throw inputError({.where = source.path,
                    .found = "no camera '" + name + "'",
                    .expected = "one of " + namesOf(source),
                    .next_step = "write FILE#NAME"});
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

// --read-as is for coefficients that do not say what they are; it does not overrule a file that does.
void refuseOtherModel(const StatedCamera& camera, const std::string& model, const std::string& where) {
  if (model.empty() || camera.camera.modelId() == model) return;
  throw inputError({.where = where,
                    .found = "found a file that states a " + std::string(camera.camera.modelId()) + " camera",
                    .expected = "a " + model + " camera, as --read-as says",
                    .next_step = "leave --read-as away; to fit another model: alidade convert --model"});
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
    for (std::size_t i = 0; i < source.cameras.size(); ++i) {
      StatedCamera& camera = source.cameras[i];
      takeSize(camera, options.image_size, name);
      refuseOtherModel(camera, options.model, name);
      const auto has_name = [&](const StatedCamera& c) { return !c.name.empty() && c.name == camera.name; };
      if (std::any_of(source.cameras.begin(), source.cameras.begin() + static_cast<std::ptrdiff_t>(i),
                      has_name)) {
        throw inputError({.where = name,
                          .found = "found two cameras '" + camera.name + "'",
                          .expected = "a name of its own for each",
                          .next_step = "rename or remove one"});
      }
    }
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

FileKind kindOfFile(const std::string& path) {
  try {
    const detail::CameraDocument document(readTextFile(path, kMaxFileBytes), path);
    if (formatOf(document) != nullptr) return FileKind::kCamera;
    // Any text may stand in a .txt; the other extensions promise a tree.
    if (path.ends_with(".txt")) return FileKind::kOther;
    static_cast<void>(document.root());
    return FileKind::kOther;
  } catch (const Error&) {
    return FileKind::kDamaged;
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

CameraFile onlyCamera(const CameraSource& source) {
  if (source.cameras.size() > 1) {
    throw inputError({.where = source.path,
                      .found = std::to_string(source.cameras.size()) + " cameras: " + namesOf(source),
                      .expected = "one camera",
                      .next_step = "name one: " + source.path + "#" + cameraLabel(source, 0)});
  }
  return cameraFileOf(source.cameras.front(), source.path);
}

CameraFile readCamera(const std::string& path, const ReadOptions& options) {
  return onlyCamera(readCameras(path, options));
}

}  // namespace alidade
