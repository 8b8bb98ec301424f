// SPDX-License-Identifier: MIT
#include "alidade/files/camera_source.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/foreign_file.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/notations.h"
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
  throw detail::errorAt(source.path, "no camera '" + name + "'", "one of " + readableText(source),
                        "select a camera with FILE#NAME");
}

void takeSize(StatedCamera& camera, const std::optional<ImageSize>& size, const std::string& where) {
  if (!size) return;
  if (camera.image_size && *camera.image_size != *size) {
    throw detail::errorAt(where, "an image size of " + sizeText(*camera.image_size) + " pixels",
                          sizeText(*size) + " from --image-size",
                          "remove --image-size; to change the image size, run: alidade convert --resize");
  }
  camera.image_size = size;
}

// --read-as is for coefficients without a stated model; it does not override a stated one.
void refuseOtherModel(const StatedCamera& camera, const std::string& model, const std::string& where) {
  if (model.empty() || camera.camera.modelId() == model) return;
  throw detail::errorAt(where,
                        "found a file that states a " + std::string(camera.camera.modelId()) + " camera",
                        "a " + model + " camera, from --read-as",
                        "remove --read-as; to fit another model, run: alidade convert --model");
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

[[noreturn]] void refuseForeign(const std::string& file, const detail::ForeignFile& foreign,
                                const std::string& text) {
  const std::string numbers = detail::cameraNumbersIn(text);
  throw NotACameraFile(detail::errorAt(
      file, "found " + foreign.what + (numbers.empty() ? "" : ", which has numbers of a camera: " + numbers),
      "a camera file in one of the formats of docs/formats.md (alidade formats)", foreign.next_step));
}

// The text with every whole word `key` replaced; of "Cam1.fx" for "Camera1.fx", the prefix of all keys.
std::string renamed(const std::string& text, std::string key, std::string meant) {
  const std::size_t dot = key.rfind('.');
  const bool is_prefix = dot != std::string::npos && dot > 0 && meant.ends_with(key.substr(dot));
  if (is_prefix) meant.resize(meant.rfind('.'));
  if (is_prefix) key.resize(dot);
  const auto isOfWord = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
  };
  std::string out;
  std::size_t from = 0;
  for (std::size_t at = 0; (at = text.find(key, at)) != std::string::npos; at += key.size()) {
    const std::size_t end = at + key.size();
    const bool is_longer = end < text.size() && isOfWord(text[end]) && !(is_prefix && text[end] == '.');
    if ((at > 0 && isOfWord(text[at - 1])) || is_longer) continue;
    out += text.substr(from, at - from) + meant;
    from = end;
  }
  return out + text.substr(from);
}

// True if the file can be read when this key, and others that resemble keys of the format, are renamed.
bool canReadRenamed(const detail::CameraDocument& document, FormatGuess guess, const ReadOptions& options) {
  std::string text = document.text();
  constexpr int kMaxSlips = 4;
  for (int i = 0; i < kMaxSlips && guess.key != guess.meant; ++i) {
    text = renamed(text, guess.key, guess.meant);
    const detail::CameraDocument mended(text, document.file());
    if (const CameraFormat* const format = formatOf(mended)) {
      try {
        return !format->read(mended, options).cameras.empty();
      } catch (const Error&) {
        // Another key may be wrong too.
      }
    }
    const auto next = guessFormat(text);
    if (!next) return false;
    guess = *next;
  }
  return false;
}

[[noreturn]] void throwUnknownFormat(const detail::CameraDocument& document, const ReadOptions& options) {
  const std::string& file = document.file();
  const std::string& text = document.text();
  if (const auto foreign = detail::knownForeignFile(text, file)) refuseForeign(file, *foreign, text);
  const bool is_free_text = isFreeText(file) && !document.isMap();
  const auto guess = is_free_text ? std::nullopt : guessFormat(text);
  const auto foreign = guess || !document.isTree() ? std::nullopt : detail::foreignText(text);
  if (foreign) refuseForeign(file, *foreign, text);
  if (!document.isTree() && !is_free_text) {
    try {
      static_cast<void>(document.root());
    } catch (const Error& reason) {
      // An interrupted write may leave an empty file.
      if (!guess && !trim(text).empty()) throw NotACameraFile(reason);
      throw;
    }
  }
  const std::string numbers = detail::cameraNumbersIn(text);
  const std::string found = numbers.empty() ? "" : "; numbers of a camera in it: " + numbers;
  if (guess) {
    const bool is_slip = guess->key != guess->meant;
    const bool is_helped = is_slip && canReadRenamed(document, *guess, options);
    const std::string title(guess->format->title);
    throw detail::errorAt(
        file + ":" + std::to_string(guess->line) + ": " + guess->key,
        is_helped ? "an unknown key in a file that most resembles the format " + title
                  : "a file of unknown format that most resembles " + title + found,
        is_slip || guess->missing.empty() ? "" : "the key '" + guess->missing + "'",
        is_helped ? "did you mean '" + guess->meant + "'?"
        : is_slip ? "other names of its keys would not do; write the numbers as a file of docs/formats.md"
                  : "see docs/formats.md for the keys of this format");
  }
  throw NotACameraFile(detail::errorAt(
      file, "not a camera file: it has no key of a camera format" + found, "",
      "the camera file comes first; see docs/formats.md for the formats; Alidade's own start with: alidade_camera: 1"));
}

void refuseSameNames(const CameraSource& source) {
  std::set<std::string> names;
  const auto take = [&](const std::string& name) {
    if (name.empty() || names.insert(name).second) return;
    throw detail::errorAt(source.path, "found two cameras named '" + name + "'",
                          "a different name for each camera", "rename or remove one of them");
  };
  for (const StatedCamera& camera : source.cameras) take(camera.name);
  for (const RefusedCamera& camera : source.refused) take(camera.name);
  for (const std::string& name : source.passed) take(name);
}

// Parses without recomputing anything.
CameraSource parsedAsStated(const std::string& content, const std::string& name, const ReadOptions& options) {
  const std::string text = detail::isCameraBinary(content) ? detail::binaryAsText(content, name) : content;
  try {
    detail::checkUtf8(text, name);
  } catch (const Error& e) {
    if (const auto foreign = detail::knownForeignFile(text, name)) refuseForeign(name, *foreign, "");
    if (isFreeText(name) || !guessFormat(text)) throw NotACameraFile(e);
    throw;
  }
  const detail::CameraDocument document(text, name);
  const CameraFormat* const format =
      options.format.empty() ? formatOf(document) : &cameraFormat(options.format);
  if (format != nullptr) {
    CameraSource source = format->read(document, options);
    source.path = name;
    source.format = format->id;
    source.format_name = format->title;
    if (source.cameras.empty() && !source.refused.empty()) throw Error(source.refused.front().reason);
    if (source.cameras.empty() && source.passed.empty()) {
      throw detail::errorAt(name, "no camera in a file of the format " + std::string(format->title),
                            "at least one");
    }
    for (StatedCamera& camera : source.cameras) {
      takeSize(camera, options.image_size, name);
      refuseOtherModel(camera, options.model, name);
    }
    if (options.applies_roi && !format->holds_part && !source.cameras.empty()) {
      source.cameras.front().remarks.push_back(
          {"assumed", name + ": --apply-roi changes nothing, because files of the format " +
                          std::string(format->title) + " do not state a part of the image"});
    }
    refuseSameNames(source);
    return source;
  }
  throwUnknownFormat(document, options);
}

// Bytes from the start of a file that cannot be read as text.
std::string headOf(const std::string& file) {
  std::string head(4096, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  return head;
}

std::string cameraText(const std::string& file) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(file, unknown);
  try {
    if (!unknown && size > kMaxCameraFileBytes) {
      throw NotACameraFile(
          detail::errorAt(file, std::to_string(size) + " bytes",
                          "a camera file of at most " + std::to_string(kMaxCameraFileBytes) + " bytes"));
    }
    std::string content = readBinaryFile(file, kMaxCameraFileBytes);
    return detail::isCameraBinary(content) ? content : textOf(std::move(content), file);
  } catch (const Error& e) {
    const auto foreign = unknown ? std::nullopt : detail::knownForeignFile(headOf(file), file);
    if (foreign) refuseForeign(file, *foreign, "");
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
  throw detail::errorAt(
      fmt::format("{}: self_check[{}]", where, idx), found + ": a number in the file was changed",
      fmt::format("a difference of at most {} px, inside the image", kSelfCheckPx),
      "alidade validate " + where +
          "; then restore the file, or delete self_check if you changed the numbers on purpose");
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

bool hasCameraFormat(const std::string& path) {
  constexpr std::uintmax_t kMaxBytes = 4U << 20U;
  try {
    if (std::filesystem::file_size(path) > kMaxBytes) return false;
    std::string content = cameraText(path);
    if (detail::isCameraBinary(content)) content = detail::binaryAsText(content, path);
    return formatOf(detail::CameraDocument(content, path)) != nullptr;
  } catch (const std::exception&) {
    return false;  // it cannot be read
  }
}

CameraSource parseCameras(const std::string& text, const std::string& name, const ReadOptions& options) {
  return selfChecked(parsedAsStated(text, name, options));
}

void requireAll(const CameraSource& source) {
  if (source.refused.empty()) return;
  throw detail::errorAt(source.path,
                        std::to_string(source.refused.size()) + " of " +
                            std::to_string(source.cameras.size() + source.refused.size()) +
                            " cameras are not supported: " + namesOf(source.refused),
                        "only supported cameras",
                        "run alidade validate to see why, or select another camera: " + source.path + "#" +
                            cameraLabel(source.cameras.front()));
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
    throw detail::errorAt(where, "no image size", "a file that states it, or --image-size",
                          "add --image-size WIDTHxHEIGHT in pixels; if a command has no such flag, "
                          "use alidade convert first");
  }
  return {.camera = camera.camera, .image_size = *camera.image_size};
}

CameraRecord onlyCamera(const CameraSource& source) {
  const std::size_t num_all = source.cameras.size() + source.refused.size();
  if (num_all > 1) {
    throw detail::errorAt(source.path, std::to_string(num_all) + " cameras: " + readableText(source),
                          "one camera",
                          "select one: " + source.path + "#" + cameraLabel(source.cameras.front()));
  }
  return recordOf(source.cameras.front(), source.path);
}

CameraRecord loadCamera(const std::string& path, const ReadOptions& options) {
  return onlyCamera(loadCameras(path, options));
}

std::string cameraText(const CameraRecord& record, std::string_view format, const std::string& path) {
  const CameraFormat& chosen = cameraFormat(format);
  // Only Alidade's own format stores the rest of the record.
  if (&chosen == cameraFormats().front()) return cameraFileText(record);
  const std::array<NamedCamera, 1> named = {
      NamedCamera{.name = record.name.name, .camera = record.camera, .image_size = record.image_size}};
  return formatText(chosen, named, path);
}

void saveCamera(const std::string& path, const CameraRecord& record, std::string_view format) {
  writeFileAtomically(path, cameraText(record, format, path));
}

}  // namespace alidade
