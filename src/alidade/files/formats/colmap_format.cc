// SPDX-License-Identifier: MIT
// COLMAP's cameras.txt: one line per camera, ID MODEL WIDTH HEIGHT PARAMS (COLMAP's documentation, "Output
// format"; names and orders of the parameters in colmap/sensor/models.h). COLMAP counts pixels from the
// image's corner: the centre of the first one is (0.5, 0.5).
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/colmap_lenses.h"
#include "alidade/files/formats/lens_numbers.h"

namespace alidade::detail::formats {
namespace colmap_format {

struct Line {
  std::string place;  // "cameras.txt:4"
  std::vector<std::string> words;
};

// All lines except comments and empty ones, up to `max_count`.
std::vector<Line> linesOf(const CameraDocument& document, std::size_t max_count) {
  std::vector<Line> lines;
  std::size_t number = 0;
  for (const std::string_view text : split(document.text(), '\n')) {
    ++number;
    std::vector<std::string> fields = words(text);
    if (fields.empty() || fields.front().starts_with('#')) continue;
    lines.push_back({document.file() + ":" + std::to_string(number), std::move(fields)});
    if (lines.size() == max_count) break;
  }
  return lines;
}

bool isModelName(std::string_view word) {
  return word.size() > 2 &&
         std::all_of(word.begin(), word.end(),
                     [](char c) { return c == '_' || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }) &&
         word.front() >= 'A';
}

bool recognises(const CameraDocument& document) {
  if (document.isMap()) return false;
  const std::vector<Line> lines = linesOf(document, 1);
  if (lines.empty())
    return document.text().find("# Camera list with one line of data per camera") != std::string::npos;
  const std::vector<std::string>& words = lines.front().words;
  return words.size() > 4 && parseInt(words[0]) && isModelName(words[1]) && parseDouble(words[2]) &&
         parseDouble(words[3]);
}

[[noreturn]] void complain(const Line& line, const std::string& found, const std::string& expected,
                           const std::string& next_step) {
  throw inputError(
      {.where = line.place, .found = "found " + found, .expected = expected, .next_step = next_step});
}

int sideOf(const Line& line, const std::string& word) {
  constexpr int kMaxSide = 1'000'000;
  const auto side = parseInt(word);
  if (!side || *side < 1 || *side > kMaxSide)
    complain(line, "'" + word + "'", "a whole number of pixels, 1 to 1000000",
             "use the size of the image files");
  return *side;
}

const LensLayout& lensOf(const Line& line) {
  if (const LensLayout* lens = findLayout(kColmapLenses, line.words[1])) return *lens;
  throw UnsupportedCamera(
      inputError({.where = line.place,
                  .found = "found the camera model " + line.words[1],
                  .expected = "one of " + join(layoutNames(kColmapLenses), ", "),
                  .next_step = "run COLMAP with one of these models, or remove the camera from the file"}));
}

// A camera's line in Alidade's conventions, before a camera is made from it.
struct Statement {
  std::string_view model;
  std::vector<StatedNumber> parameters;
  ImageSize size;
};

Statement parseLine(const Line& line) {
  constexpr std::size_t kNumBefore = 4;
  if (line.words.size() <= kNumBefore)
    complain(line, std::to_string(line.words.size()) + " words", "ID MODEL WIDTH HEIGHT PARAMS",
             "complete the line, or remove it");
  if (!parseInt(line.words[0]))
    complain(line, "'" + line.words[0] + "'", "a camera number",
             "start the line with a camera number, or remove it");
  const LensLayout& lens = lensOf(line);
  const std::vector<std::string> names = words(lens.order);
  if (line.words.size() != kNumBefore + names.size()) {
    complain(line, std::to_string(line.words.size() - kNumBefore) + " parameters",
             std::to_string(names.size()) + " for " + std::string(lens.name) + ": " + join(names, " "),
             "correct the model, or write all of its parameters");
  }
  std::vector<StatedNumber> listed;
  for (std::size_t i = kNumBefore; i < line.words.size(); ++i) {
    const auto number = parseDouble(line.words[i]);
    if (!number || !std::isfinite(*number))
      complain(line, "'" + line.words[i] + "'", "a finite number for " + names[i - kNumBefore],
               "correct it, or remove the camera from the file");
    listed.push_back({*number});
  }
  std::vector<StatedNumber> parameters = storageOrder(lens, listed);
  takeOrigin(parameters, kColmapOrigin);
  const ImageSize size = {.width = sideOf(line, line.words[2]), .height = sideOf(line, line.words[3])};
  return {.model = lens.model, .parameters = std::move(parameters), .size = size};
}

StatedCamera readLine(const Line& line) {
  const Statement stated = parseLine(line);
  return stateCamera(line.place, line.words[0], stated.model, stated.parameters, stated.size);
}

// Throws what readLine() throws, except for an unsupported model; makes no camera.
void checkLine(const Line& line) {
  try {
    const Statement stated = parseLine(line);
    for (std::size_t i = 0; i < stated.parameters.size(); ++i) {
      // Making the camera throws the error with its place.
      if (parameterComplaint(stated.model, i, stated.parameters[i].value)) static_cast<void>(readLine(line));
    }
  } catch (const UnsupportedCamera&) {
    return;  // unsupported, but not damaged
  }
}

// The count in the comment "# Number of cameras: 2", with its line.
struct StatedCount {
  std::string place;
  int count = 0;
};

std::optional<StatedCount> statedCount(const CameraDocument& document) {
  constexpr std::string_view kStart = "# Number of cameras:";
  std::size_t number = 0;
  for (const std::string_view line : split(document.text(), '\n')) {
    ++number;
    if (!line.starts_with(kStart)) continue;
    const std::string_view rest = trim(line.substr(kStart.size()));
    const auto count = parseInt(rest.substr(0, rest.find_first_of(", \t")));
    if (!count) return std::nullopt;
    return StatedCount{.place = document.file() + ":" + std::to_string(number), .count = *count};
  }
  return std::nullopt;
}

StatedCameras read(const CameraDocument& document, const ReadOptions& options) {
  constexpr std::size_t kMaxCameras = 100'000;
  StatedCameras all;
  const std::vector<Line> lines = linesOf(document, kMaxCameras + 1);
  if (lines.empty()) {
    throw inputError({.where = document.file(),
                      .found = "found only comments",
                      .expected = "a line ID MODEL WIDTH HEIGHT PARAMS for each camera",
                      .next_step = "export the model again: colmap model_converter --output_type TXT"});
  }
  if (lines.size() > kMaxCameras)
    complain(lines.back(), "more than " + std::to_string(kMaxCameras) + " cameras", "fewer",
             "split the file");
  for (const Line& line : lines) {
    const std::string& name = line.words[0];
    if (options.only.empty() || name == options.only) {
      all.add(name, [&line] { return readLine(line); });
    } else {
      checkLine(line);
      all.passed.push_back(name);
    }
  }
  const auto stated = statedCount(document);
  if (stated && stated->count != static_cast<int>(lines.size()) && !all.cameras.empty()) {
    // Applies to the whole file, so it is stated once.
    all.cameras.front().remarks.push_back(
        {"assumed", stated->place + ": the header states " + std::to_string(stated->count) +
                        " cameras, but the file contains " + std::to_string(lines.size()) +
                        "; it was read, but it may be truncated"});
  }
  return all;
}

std::string write(std::span<const NamedCamera> cameras) {
  std::string text = fmt::format(
      "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
      "# Number of cameras: {}\n",
      cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const LensLayout& lens = layoutOf(kColmapLenses, cameras[i].camera.modelId());
    text += fmt::format("{} {} {} {}", i + 1, lens.name, cameras[i].image_size.width,
                        cameras[i].image_size.height);
    for (const double value : listedOrder(lens, cameras[i].camera, kColmapOrigin))
      text += " " + exactText(value);
    text += "\n";
  }
  return text;
}

}  // namespace colmap_format

const CameraFormat& colmap() {
  using namespace colmap_format;
  static const CameraFormat kFormat = {
      .id = "colmap",
      .title = "COLMAP cameras.txt",
      .models = {"pinhole", "radtan", "rational", "kannala_brandt", "fov", "eucm"},
      .absent = {{"radtan", "k3"}},
      .max_cameras = CameraFormat::kAnyNumber,
      .recognises = recognises,
      .read = read,
      .write = write};
  return kFormat;
}

}  // namespace alidade::detail::formats
