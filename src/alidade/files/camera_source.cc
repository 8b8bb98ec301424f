// SPDX-License-Identifier: MIT
#include "alidade/files/camera_source.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/file_text.h"

namespace alidade {
namespace {

constexpr std::size_t kMaxCameraFileBytes = 64U << 20U;

// The path, and the name of the camera; empty = none was given. If a file's own name contains a #, the whole
// text is the path.
std::pair<std::string, std::string> splitPath(const std::string& text) {
  const std::size_t at = text.rfind('#');
  std::error_code error;
  if (at == std::string::npos || std::filesystem::exists(text, error)) return {text, ""};
  return {text.substr(0, at), text.substr(at + 1)};
}

template <class Cameras>
std::string namesOf(const Cameras& cameras) {
  constexpr std::size_t kMaxNamed = 20;
  std::vector<std::string> names;
  for (const auto& camera : cameras) {
    if (names.size() < kMaxNamed) names.push_back(cameraLabel(camera));
  }
  const std::size_t num_more = cameras.size() - names.size();
  return join(names, ", ") + (num_more > 0 ? " and " + std::to_string(num_more) + " more" : "");
}

// "1, 3 (not supported: 2)".
std::string readableText(const CameraSource& source) {
  const std::string readable = namesOf(source.cameras);
  return source.refused.empty() ? readable : readable + " (not supported: " + namesOf(source.refused) + ")";
}

bool isNumber(const std::string& name) {
  return !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
}

template <class Cameras>
bool anyIsNumber(const Cameras& cameras) {
  return std::any_of(cameras.begin(), cameras.end(), [](const auto& c) { return isNumber(c.name); });
}

// The camera with this name, else with this number. @throws the stored reason if it is refused
std::optional<StatedCamera> findCamera(const CameraSource& source, const std::string& name,
                                       std::optional<std::size_t> number) {
  const auto isMeant = [&](const auto& camera) {
    return number ? camera.number == *number : camera.name == name;
  };
  const auto found = std::find_if(source.cameras.begin(), source.cameras.end(), isMeant);
  if (found != source.cameras.end()) return *found;
  const auto refused = std::find_if(source.refused.begin(), source.refused.end(), isMeant);
  if (refused != source.refused.end()) throw Error(refused->reason);
  return std::nullopt;
}

StatedCamera cameraNamed(const CameraSource& source, const std::string& name) {
  if (const auto camera = findCamera(source, name, std::nullopt)) return *camera;
  // If names are numbers, as in COLMAP, an unknown number is an error and not an index.
  const bool has_numbers = anyIsNumber(source.cameras) || anyIsNumber(source.refused);
  if (const auto number = isNumber(name) && !has_numbers ? parseInt(name) : std::nullopt) {
    if (const auto camera = findCamera(source, name, static_cast<std::size_t>(*number))) return *camera;
  }
  throw inputError({.where = source.path,
                    .found = "no camera '" + name + "'",
                    .expected = "one of " + readableText(source),
                    .next_step = "select a camera with FILE#NAME"});
}

void takeSize(StatedCamera& camera, const std::optional<ImageSize>& size, const std::string& where) {
  if (!size) return;
  if (camera.image_size && *camera.image_size != *size) {
    throw inputError(
        {.where = where,
         .found = "an image size of " + sizeText(*camera.image_size) + " pixels",
         .expected = sizeText(*size) + " from --image-size",
         .next_step = "remove --image-size; to change the image size, run: alidade convert --resize"});
  }
  camera.image_size = size;
}

// --read-as is for coefficients without a stated model; it does not override a stated one.
void refuseOtherModel(const StatedCamera& camera, const std::string& model, const std::string& where) {
  if (model.empty() || camera.camera.modelId() == model) return;
  throw inputError({.where = where,
                    .found = "found a file that states a " + std::string(camera.camera.modelId()) + " camera",
                    .expected = "a " + model + " camera, from --read-as",
                    .next_step = "remove --read-as; to fit another model, run: alidade convert --model"});
}

const CameraFormat* formatOf(const detail::CameraDocument& document) {
  for (const CameraFormat* format : cameraFormats()) {
    if (format->recognises(document)) return format;
  }
  return nullptr;
}

// A .txt file may contain any text; the other extensions promise YAML, JSON or XML.
bool isFreeText(const std::string& file) {
  return file.ends_with(".txt");
}

[[noreturn]] void throwUnknownFormat(const detail::CameraDocument& document) {
  const std::string& file = document.file();
  const bool is_free_text = isFreeText(file) && !document.isMap();
  const auto guess = is_free_text ? std::nullopt : guessFormat(document.text());
  if (!document.isTree()) {
    try {
      static_cast<void>(document.root());
    } catch (const Error& reason) {
      // An interrupted write may leave an empty file.
      const bool is_empty = trim(document.text()).empty() && !is_free_text;
      if (!guess && !is_empty) throw NotACameraFile(reason);
      throw;
    }
  }
  if (guess) {
    const bool is_slip = guess->key != guess->meant;
    const std::string title(guess->format->title);
    throw inputError({.where = file + ":" + std::to_string(guess->line) + ": " + guess->key,
                      .found = is_slip ? "an unknown key in a file that most resembles the format " + title
                                       : "a file of unknown format that most resembles " + title,
                      .expected = is_slip || guess->missing.empty() ? "" : "the key '" + guess->missing + "'",
                      .next_step = is_slip ? "did you mean '" + guess->meant + "'?"
                                           : "see docs/formats.md for the keys of this format"});
  }
  throw NotACameraFile(inputError(
      {.where = file,
       .found = "not a camera file: it has no key of a camera format",
       .next_step =
           "see docs/formats.md for the formats; Alidade's own files start with: alidade_camera: 1"}));
}

void refuseSameNames(const CameraSource& source, const std::vector<std::string>& passed) {
  std::set<std::string> names;
  const auto take = [&](const std::string& name) {
    if (name.empty() || names.insert(name).second) return;
    throw inputError({.where = source.path,
                      .found = "found two cameras named '" + name + "'",
                      .expected = "a different name for each camera",
                      .next_step = "rename or remove one of them"});
  };
  for (const StatedCamera& camera : source.cameras) take(camera.name);
  for (const RefusedCamera& camera : source.refused) take(camera.name);
  for (const std::string& name : passed) take(name);
}

// Parses without recomputing anything.
CameraSource parsedAsStated(const std::string& text, const std::string& name, const ReadOptions& options) {
  try {
    detail::checkUtf8(text, name);
  } catch (const Error& e) {
    if (isFreeText(name) || !guessFormat(text)) throw NotACameraFile(e);
    throw;
  }
  const detail::CameraDocument document(text, name);
  if (const CameraFormat* format = formatOf(document)) {
    StatedCameras read = format->read(document, options);
    CameraSource source{.path = name,
                        .format = format->id,
                        .format_name = format->title,
                        .cameras = std::move(read.cameras),
                        .refused = std::move(read.refused),
                        .readRigRest = std::move(read.readRigRest)};
    if (source.cameras.empty() && !source.refused.empty()) throw Error(source.refused.front().reason);
    if (source.cameras.empty() && read.passed.empty()) {
      throw inputError({.where = name,
                        .found = "no camera in a file of the format " + std::string(format->title),
                        .expected = "at least one"});
    }
    for (StatedCamera& camera : source.cameras) {
      takeSize(camera, options.image_size, name);
      refuseOtherModel(camera, options.model, name);
    }
    refuseSameNames(source, read.passed);
    return source;
  }
  throwUnknownFormat(document);
}

std::string cameraText(const std::string& file) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(file, unknown);
  if (!unknown && size > kMaxCameraFileBytes) {
    throw NotACameraFile(inputError(
        {.where = file,
         .found = std::to_string(size) + " bytes",
         .expected = "a camera file of at most " + std::to_string(kMaxCameraFileBytes) + " bytes"}));
  }
  try {
    return readTextFile(file, kMaxCameraFileBytes);
  } catch (const Error& e) {
    if (isFreeText(file) && !unknown) throw NotACameraFile(e);
    throw;
  }
}

// Checks that the camera projects the file's self-check points to their pixels (if there are any), so that a
// manually changed number is not used silently.
void requireSelfCheck(const CameraRecord& file, const std::string& where) {
  const SelfCheckOutcome outcome = runSelfCheck(file.camera, file.image_size, file.self_check);
  if (outcome.isPassed()) return;
  const std::size_t idx = outcome.outside_image.value_or(outcome.worst);
  const SelfCheckPoint& point = file.self_check[idx];
  const std::string pixel = fmt::format("({:.6g}, {:.6g})", point.pixel.x(), point.pixel.y());
  std::string found;
  if (outcome.outside_image) {
    found = fmt::format("the stated pixel {} is outside the image of {}x{} px", pixel, file.image_size.width,
                        file.image_size.height);
  } else if (std::isfinite(outcome.worst_px)) {
    found = fmt::format("the parameters project this point {:.3g} px away from its stated pixel {}",
                        outcome.worst_px, pixel);
  } else {
    found = "the parameters cannot project this point; its stated pixel is " + pixel;
  }
  throw inputError(
      {.where = fmt::format("{}: self_check[{}]", where, idx),
       .found = found + ": a number in the file was changed",
       .expected = fmt::format("a difference of at most {} px, inside the image", kSelfCheckPx),
       .next_step = "alidade validate " + where +
                    "; then restore the file, or delete self_check if you changed the numbers on purpose"});
}

CameraSource selfChecked(CameraSource source) {
  for (const StatedCamera& camera : source.cameras) {
    if (camera.own) requireSelfCheck(*camera.own, source.path);
  }
  return source;
}

}  // namespace

CameraSource readCamerasToJudge(const std::string& path, const ReadOptions& options) {
  const auto [file, name] = splitPath(path);
  const std::string text = cameraText(file);
  ReadOptions one = options;
  one.only = name;
  CameraSource source = parsedAsStated(text, file, one);
  // If the selection is an index or matches nothing, all names are needed.
  if (source.cameras.empty()) source = parsedAsStated(text, file, options);
  if (!name.empty()) {
    source.cameras = {cameraNamed(source, name)};
    source.refused.clear();
    source.readRigRest = nullptr;
  }
  return source;
}

CameraSource parseCameras(const std::string& text, const std::string& name, const ReadOptions& options) {
  return selfChecked(parsedAsStated(text, name, options));
}

void requireAll(const CameraSource& source) {
  if (source.refused.empty()) return;
  throw inputError({.where = source.path,
                    .found = std::to_string(source.refused.size()) + " of " +
                             std::to_string(source.cameras.size() + source.refused.size()) +
                             " cameras are not supported: " + namesOf(source.refused),
                    .expected = "only supported cameras",
                    .next_step = "run alidade validate to see why, or select another camera: " + source.path +
                                 "#" + cameraLabel(source.cameras.front())});
}

std::string cameraFilePath(const std::string& path) {
  return splitPath(path).first;
}

CameraSource loadCameras(const std::string& path, const ReadOptions& options) {
  return selfChecked(readCamerasToJudge(path, options));
}

CameraRecord recordOf(const StatedCamera& camera, const std::string& where) {
  if (camera.own) return *camera.own;
  if (!camera.image_size) {
    throw inputError({.where = where,
                      .found = "no image size",
                      .expected = "a file that states it, or --image-size",
                      .next_step = "add --image-size WIDTHxHEIGHT in pixels; if a command has no such flag, "
                                   "use alidade convert first"});
  }
  return {.camera = camera.camera, .image_size = *camera.image_size};
}

CameraRecord onlyCamera(const CameraSource& source) {
  const std::size_t num_all = source.cameras.size() + source.refused.size();
  if (num_all > 1) {
    throw inputError({.where = source.path,
                      .found = std::to_string(num_all) + " cameras: " + readableText(source),
                      .expected = "one camera",
                      .next_step = "select one: " + source.path + "#" + cameraLabel(source.cameras.front())});
  }
  return recordOf(source.cameras.front(), source.path);
}

CameraRecord loadCamera(const std::string& path, const ReadOptions& options) {
  return onlyCamera(loadCameras(path, options));
}

}  // namespace alidade
