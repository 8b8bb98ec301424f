// SPDX-License-Identifier: MIT
#include "detection_stage.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <mutex>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/detect/draw_detection.h"
#include "alidade/files/table_lines.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_list.h"
#include "one_line.h"
#include "progress.h"

namespace alidade {
namespace {

[[noreturn]] void throwNoBoard(const BoardSurvey& survey, bool has_debug_flag) {
  const std::vector<std::string>& paths = survey.paths;
  std::map<DetectionReason, int> counts;
  for (const ImageOutcome& outcome : survey.outcomes) ++counts[outcome.detection.reason];
  if (counts.contains(DetectionReason::kUnreadable) && counts.size() == 1) {
    const std::string& first = survey.outcomes.front().detection.detail;
    if (paths.size() == 1) throw inputError({.where = first});
    throw inputError({.where = fmt::format("{} images", paths.size()),
                      .found = "none of them can be read",
                      .expected = "images of a board",
                      .next_step = "the error of the first one: " + oneLine(first)});
  }
  std::vector<std::string> reasons;
  for (const auto& [reason, count] : counts)
    reasons.push_back(fmt::format("{} {}", count, reasonCode(reason)));
  const auto hint = diagnoseBoard(survey.outcomes, survey.board);
  throw inputError(
      {.where = paths.size() == 1 ? paths.front() : fmt::format("{} images", paths.size()),
       .found = fmt::format("no board ({})", join(reasons, ", ")),
       .expected = fmt::format("a checkerboard of {}x{} inner corners (columns x rows)", survey.board.columns,
                               survey.board.rows),
       .next_step = hint ? hintText(*hint, survey.board)
                         : "check that the board is in the image, is sharp and has a white margin; " +
                               std::string(has_debug_flag ? "--debug DIR" : "alidade detect --debug DIR") +
                               " draws what was detected into the images"});
}

// Where the debug images go, by path of the input. Names that differ in folders only stay apart, and long
// ones leave room for what is added to them.
std::map<std::string, std::string> debugPaths(const std::string& folder,
                                              const std::vector<std::string>& paths,
                                              const std::vector<std::string>& names) {
  constexpr std::size_t kMaxLength = 180;
  std::map<std::string, std::string> result;
  std::map<std::string, int> num_taken;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    std::string name = names[i].substr(names[i].size() - std::min(names[i].size(), kMaxLength));
    std::replace(name.begin(), name.end(), '/', '_');
    const int number = ++num_taken[name];
    if (number > 1) name += fmt::format("-{}", number);
    result[paths[i]] = (std::filesystem::path(folder) / (name + ".detection.png")).string();
  }
  return result;
}

void prepareDebugFolder(const std::string& folder, const std::vector<std::string>& images) {
  std::error_code error;
  for (const std::string& image : images) {
    const std::filesystem::path parent = std::filesystem::path(image).parent_path();
    if (!std::filesystem::equivalent(parent.empty() ? "." : parent, folder, error)) continue;
    throw usageError(
        {.where = "--debug " + folder,
         .found = "this is the folder of the input " + image,
         .expected = "a different folder",
         .next_step = "choose another folder, otherwise the next run would read the debug images as inputs"});
  }
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw inputError({.where = "--debug " + folder,
                      .found = error ? error.message() : "a file with this name exists",
                      .expected = "a writable folder, or a new one"});
  }
}

}  // namespace

DetectionStage runDetection(const DetectionRequest& request, const CommonOptions& options,
                            const CancelFlag* cancel) {
  const std::vector<std::string> paths = listImages(request.inputs);
  DetectImagesOptions detect_options;
  detect_options.num_jobs = options.jobs;
  detect_options.cancel = cancel;
  std::map<std::string, std::string> debug_paths;
  std::mutex mutex;
  std::string debug_complaint;  // a drawing that cannot be written is no reason to lose the corners
  if (!request.debug_folder.empty()) {
    prepareDebugFolder(request.debug_folder, paths);
    debug_paths = debugPaths(request.debug_folder, paths, shortNames(paths));
    detect_options.inspect = [&](const GrayImage& image, const ImageOutcome& outcome) {
      try {
        writeColorPng(debug_paths.at(outcome.image), drawDetection(image, outcome.detection, request.board));
      } catch (const Error& error) {
        const std::lock_guard lock(mutex);
        debug_complaint = oneLine(error.what());
      }
    };
  }
  DetectionStage stage;
  {
    ProgressBar bar("detecting boards", options.quiet);
    detect_options.progress = [&bar](std::size_t done, std::size_t total) { bar.update(done, total); };
    stage.survey = surveyImages(paths, request.board, detect_options);
  }
  for (const SurveyNote& note : stage.survey.notes)
    stage.notes.push_back(diagnosisOf(note, stage.survey).message());
  if (!debug_complaint.empty())
    stage.notes.push_back("some debug images could not be written: " + debug_complaint);
  return stage;
}

void requireBoards(const BoardSurvey& survey, const CommonOptions& options, bool has_debug_flag) {
  if (survey.numFound() > 0) return;
  if (!options.quiet && survey.outcomes.size() > 1) {
    constexpr std::size_t kMaxListed = 12;
    const std::vector<std::string> lines = reasonLines(survey);
    for (std::size_t i = 0; i < std::min(lines.size(), kMaxListed); ++i) printMessage("  " + lines[i]);
    if (lines.size() > kMaxListed) printMessage(fmt::format("  ... and {} more", lines.size() - kMaxListed));
  }
  throwNoBoard(survey, has_debug_flag);
}

void checkDebugFolder(const std::string& folder, const std::string& output) {
  const auto normal = [](const std::string& path) {
    const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
    return whole.has_filename() ? whole : whole.parent_path();
  };
  if (folder.empty() || output.empty() || normal(folder) != normal(output)) return;
  throw usageError(
      {.where = "--debug " + folder, .found = "this is also the output", .expected = "a different folder"});
}

void addDebugOption(CLI::App& app, std::string& folder) {
  app.add_option("--debug", folder,
                 "Folder for copies of the images with the corners, their ids and the board's axes drawn in");
}

std::vector<std::string> reasonLines(const BoardSurvey& survey) {
  std::vector<std::string> lines;
  for (const ImageOutcome& outcome : survey.outcomes) {
    if (const auto why = diagnosisOf(outcome))
      lines.push_back(oneLine(fmt::format("{}: {}: {}", why->cause, why->id, why->evidence)));
  }
  return lines;
}

std::string measuresText(const BoardSurvey& survey) {
  const auto range = [&](const auto& measure) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const ImageOutcome& outcome : survey.outcomes) {
      if (!outcome.detection.hasCorners()) continue;
      low = std::min(low, measure(outcome.detection.measures));
      high = std::max(high, measure(outcome.detection.measures));
    }
    return fmt::format("{:.3g} to {:.3g}", low, high);
  };
  if (survey.numFound() == 0) return {};
  return fmt::format("edge blur {} px, square width {} px, tilt {} degrees, board area {} % of the image",
                     range([](const ViewMeasures& m) { return m.blur_px; }),
                     range([](const ViewMeasures& m) { return m.spacing_px; }),
                     range([](const ViewMeasures& m) { return m.tilt_deg; }),
                     range([](const ViewMeasures& m) { return 100 * m.area_share; }));
}

std::vector<std::string> imageTable(const BoardSurvey& survey) {
  std::vector<std::string> lines = {
      "image,reason,corners,blur_px,spacing_px,area_share,tilt_deg,columns_seen,rows_seen,detail"};
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : ""; };
  for (const ImageOutcome& outcome : survey.outcomes) {
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
