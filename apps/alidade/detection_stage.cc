// SPDX-License-Identifier: MIT
#include "detection_stage.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/detect/draw_detection.h"
#include "alidade/detect/triage.h"
#include "alidade/io/csv.h"
#include "alidade/io/image_file.h"
#include "alidade/io/image_list.h"
#include "image_names.h"
#include "progress.h"

namespace alidade {
namespace {

SourceImage loadImage(const std::string& path) {
  if (path.find_first_of("\r\n") != std::string::npos) {
    throw inputError({.where = path,
                      .found = "a line break in the name",
                      .expected = "a name of one line, as corners files have a line a corner",
                      .next_step = "rename it"});
  }
  LoadedImage loaded = readGrayImage(path);
  return {.image = std::move(loaded.image), .exif_orientation = loaded.exif_orientation};
}

void noteOrientations(DetectionStage& stage) {
  std::map<int, int> counts;
  for (const ImageOutcome& outcome : stage.outcomes) ++counts[outcome.exif_orientation];
  counts.erase(1);
  for (const auto& [orientation, count] : counts) {
    stage.notes.push_back(fmt::format(
        "{} image{} say{} in Exif to be shown {}; the pixels are used as stored, without turning, and the "
        "camera file holds for them as stored",
        count, count == 1 ? "" : "s", count == 1 ? "s" : "", describeExifOrientation(orientation)));
  }
}

[[noreturn]] void throwNoBoard(const DetectionStage& stage, const std::vector<std::string>& paths) {
  std::map<DetectionReason, int> counts;
  for (const ImageOutcome& outcome : stage.outcomes) ++counts[outcome.detection.reason];
  if (counts.contains(DetectionReason::kUnreadable) && counts.size() == 1) {
    const std::string& first = stage.outcomes.front().detection.detail;
    if (paths.size() == 1) throw inputError({.where = first});
    throw inputError({.where = fmt::format("{} images", paths.size()),
                      .found = "none can be read",
                      .expected = "images of a board",
                      .next_step = "the first: " + oneLine(first)});
  }
  std::vector<std::string> reasons;
  for (const auto& [reason, count] : counts)
    reasons.push_back(fmt::format("{} {}", count, reasonCode(reason)));
  const auto hint = diagnoseBoard(stage.outcomes);
  throw inputError(
      {.where = paths.size() == 1 ? paths.front() : fmt::format("{} images", paths.size()),
       .found = fmt::format("no board ({})", join(reasons, ", ")),
       .expected = fmt::format("a checkerboard of {}x{} inner corners (columns x rows)", stage.board.columns,
                               stage.board.rows),
       .next_step = hint
                        ? hintText(*hint, stage.board)
                        : "check that the board is in the image, sharp, and with a white margin; --debug DIR "
                          "writes the images with what was found"});
}

// Where the debug image of an input goes. Names that differ in folders only stay apart.
std::string debugPath(const std::string& folder, std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return (std::filesystem::path(folder) / (name + ".detection.png")).string();
}

void prepareDebugFolder(const std::string& folder, const std::vector<std::string>& images) {
  std::error_code error;
  for (const std::string& image : images) {
    const std::filesystem::path parent = std::filesystem::path(image).parent_path();
    if (!std::filesystem::equivalent(parent.empty() ? "." : parent, folder, error)) continue;
    throw usageError({.where = "--debug " + folder,
                      .found = "the folder of the input " + image,
                      .expected = "another folder",
                      .next_step = "the images written there would be taken for inputs next time"});
  }
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw inputError({.where = "--debug " + folder,
                      .found = error ? error.message() : "a file of this name",
                      .expected = "a folder that can be made and written to"});
  }
}

}  // namespace

std::size_t DetectionStage::numFound() const {
  return static_cast<std::size_t>(std::count_if(
      outcomes.begin(), outcomes.end(), [](const ImageOutcome& o) { return o.detection.hasCorners(); }));
}

std::size_t DetectionStage::numWhole() const {
  return static_cast<std::size_t>(std::count_if(outcomes.begin(), outcomes.end(), [](const ImageOutcome& o) {
    return o.detection.reason == DetectionReason::kFound;
  }));
}

DetectionStage runDetection(const DetectionRequest& request, const CommonOptions& options,
                            const CancelFlag* cancel) {
  const std::vector<std::string> paths = listImages(request.inputs);
  const std::vector<std::string> names = shortNames(paths);
  DetectionStage stage;
  stage.board = request.board;
  DetectImagesOptions detect_options;
  detect_options.num_jobs = options.jobs;
  detect_options.cancel = cancel;
  std::map<std::string, std::string> debug_paths;  // by path of the image
  if (!request.debug_folder.empty()) {
    prepareDebugFolder(request.debug_folder, paths);
    for (std::size_t i = 0; i < paths.size(); ++i)
      debug_paths[paths[i]] = debugPath(request.debug_folder, names[i]);
    detect_options.inspect = [&](const GrayImage& image, const ImageOutcome& outcome) {
      writeColorPng(debug_paths.at(outcome.image), drawDetection(image, outcome.detection, request.board));
    };
  }
  {
    ProgressBar bar("finding boards", options.quiet);
    detect_options.progress = [&bar](std::size_t done, std::size_t total) { bar.update(done, total); };
    stage.outcomes = detectInImages(paths, loadImage, request.board, detect_options);
  }
  for (std::size_t i = 0; i < names.size(); ++i) stage.outcomes[i].image = names[i];
  stage.notes = triage(stage.outcomes);
  noteOrientations(stage);
  for (const ImageOutcome& outcome : stage.outcomes) {
    if (outcome.detection.hasCorners())
      stage.views.push_back({outcome.image, outcome.size, outcome.detection.corners});
  }
  if (stage.views.empty()) throwNoBoard(stage, paths);
  if (const std::string ambiguity = ambiguityText(stage.board); !ambiguity.empty())
    stage.notes.push_back(ambiguity);
  const auto hint = diagnoseBoard(stage.outcomes);
  if (hint && hint->is_closed) stage.notes.push_back(hintText(*hint, stage.board));
  return stage;
}

void addDebugOption(CLI::App& app, std::string& folder) {
  app.add_option("--debug", folder, "Folder for the images with corners, ids and directions drawn on them");
}

std::vector<std::string> reasonLines(const DetectionStage& stage) {
  std::vector<std::string> lines;
  for (const ImageOutcome& outcome : stage.outcomes) {
    if (outcome.detection.reason == DetectionReason::kFound) continue;
    lines.push_back(oneLine(fmt::format("{}: {}: {}", outcome.image, reasonCode(outcome.detection.reason),
                                        outcome.detection.detail)));
  }
  return lines;
}

std::string measuresText(const DetectionStage& stage) {
  const auto range = [&](const auto& measure) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const ImageOutcome& outcome : stage.outcomes) {
      if (!outcome.detection.hasCorners()) continue;
      low = std::min(low, measure(outcome.detection.measures));
      high = std::max(high, measure(outcome.detection.measures));
    }
    return fmt::format("{:.3g} to {:.3g}", low, high);
  };
  if (stage.views.empty()) return {};
  return fmt::format(
      "edges blurred over {} px, squares {} px wide, tilts {} degrees, {} % of the image's area",
      range([](const ViewMeasures& m) { return m.blur_px; }),
      range([](const ViewMeasures& m) { return m.spacing_px; }),
      range([](const ViewMeasures& m) { return m.tilt_deg; }),
      range([](const ViewMeasures& m) { return 100 * m.area_share; }));
}

std::vector<std::string> imageTable(const DetectionStage& stage) {
  std::vector<std::string> lines = {
      "image,reason,corners,blur_px,spacing_px,area_share,tilt_deg,columns_seen,rows_seen,detail"};
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : ""; };
  for (const ImageOutcome& outcome : stage.outcomes) {
    const Detection& detection = outcome.detection;
    const ViewMeasures& measures = detection.measures;
    const bool is_measured = std::isfinite(measures.spacing_px);
    lines.push_back(oneLine(
        fmt::format("{},{},{},{},{},{},{},{},{},{}", detail::csvField(outcome.image),
                    reasonCode(detection.reason), detection.corners.size(), number(measures.blur_px),
                    number(measures.spacing_px), is_measured ? number(measures.area_share) : "",
                    number(measures.tilt_deg), detection.seen ? std::to_string(detection.seen->columns) : "",
                    detection.seen ? std::to_string(detection.seen->rows) : "",
                    detail::csvField(oneLine(detection.detail)))));
  }
  return lines;
}

}  // namespace alidade
