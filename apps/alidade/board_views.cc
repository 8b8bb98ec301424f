// SPDX-License-Identifier: MIT
#include "board_views.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/detect/board_guess.h"
#include "alidade/detect/draw_detection.h"
#include "alidade/files/board_file.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/table_lines.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_list.h"
#include "console.h"

namespace alidade {
namespace {

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

GivenViews readCorners(const ViewsRequest& request) {
  const auto other = std::ranges::find_if_not(request.inputs, isCornersFile);
  if (other != request.inputs.end()) {
    throw usageError({.where = *other,
                      .found = "an input that is no corners file, beside " + request.inputs.front(),
                      .expected = "corners files alone, or images alone",
                      .next_step = "write the corners of the images with alidade detect first"});
  }
  CornersFile file = readCornersFiles(request.inputs);
  if (!request.board.empty() && !(readBoard(request.board) == file.board)) {
    throw inputError({.where = request.inputs.front(),
                      .found = "board " + file.board.spec(),
                      .expected = readBoard(request.board).spec() + " from --board",
                      .next_step = "remove --board: the corners file states its board"});
  }
  GivenViews given;
  given.board = file.board;
  given.num_images = given.num_found = file.views.size();
  const std::vector<ImageSize> sizes = mapped(file.views, &View::size);
  const SizeGroups groups = groupBySize(sizes);
  for (const std::size_t i : groups.others) {
    given.reasons.push_back(fmt::format("{}: other_size: {}, while most images are {}", file.views[i].image,
                                        sizeText(sizes[i]), sizeText(groups.size)));
  }
  for (const std::size_t i : groups.in_group) given.views.push_back(std::move(file.views[i]));
  return given;
}

GivenViews findBoards(const ViewsRequest& request, const CommonOptions& options, const CancelFlag* cancel) {
  DetectionStage stage = runDetection(request, options, cancel);
  requireBoards(stage.survey, options, request.debug_folder.has_value());
  const BoardSurvey& survey = stage.survey;
  return {.board = survey.board,
          .num_images = survey.outcomes.size(),
          .num_found = survey.numFound(),
          .measures = measuresText(survey),
          .reasons = reasonLines(survey),
          .notes = std::move(stage.notes),
          .views = survey.views()};
}

// For a guess: what is wrong with the inputs is said once there is a board.
std::vector<std::string> imagesIn(const std::vector<std::string>& inputs) {
  try {
    return listImages(inputs);
  } catch (const Error&) {
    return {};
  }
}

}  // namespace

DetectionStage runDetection(const ViewsRequest& request, const CommonOptions& options,
                            const CancelFlag* cancel) {
  if (request.board.empty()) {
    throw usageError({.where = request.command,
                      .found = "no --board",
                      .expected = "for example --board checkerboard:9x6:25mm",
                      .next_step = guessedBoard(imagesIn(request.inputs), cancel)});
  }
  const Board board = readBoard(request.board);
  const std::string debug_folder = request.debug_folder.value_or("");
  const std::vector<std::string> paths = listImages(request.inputs);
  DetectImagesOptions detect_options;
  detect_options.num_jobs = options.jobs;
  detect_options.cancel = cancel;
  std::map<std::string, std::string> debug_paths;
  std::mutex mutex;
  std::string debug_complaint;  // a drawing that cannot be written is no reason to lose the corners
  if (!debug_folder.empty()) {
    prepareDebugFolder(debug_folder, paths);
    debug_paths = debugPaths(debug_folder, paths, shortNames(paths));
    detect_options.inspect = [&](const GrayImage& image, const ImageOutcome& outcome) {
      try {
        writeImage(debug_paths.at(outcome.image), drawDetection(image, outcome.detection, board));
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
    stage.survey = surveyImages(paths, board, detect_options);
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
    const std::string lines = listed(reasonLines(survey));
    printMessage(lines.substr(0, lines.size() - 1));
  }
  const std::vector<std::string>& paths = survey.paths;
  std::map<DetectionReason, int> counts;
  for (const ImageOutcome& outcome : survey.outcomes) ++counts[outcome.detection.reason];
  if (counts.contains(DetectionReason::kUnreadable) && counts.size() == 1) {
    const std::string& first = survey.outcomes.front().detection.detail;
    if (paths.size() == 1) throw inputError({.found = first});
    throw noneUsableError(paths.size(), "none of them can be read", first);
  }
  std::vector<std::string> reasons;
  for (const auto& [reason, count] : counts)
    reasons.push_back(fmt::format("{} {}", count, reasonCode(reason)));
  const auto hint = diagnoseBoard(survey.outcomes, survey.board);
  throw inputError(
      {.where = paths.size() == 1 ? paths.front() : fmt::format("{} images", paths.size()),
       .found = fmt::format("no board ({})", join(reasons, ", ")),
       .expected = fmt::format("{} ({}x{} inner corners, columns x rows)", survey.board.spec(),
                               survey.board.columns(), survey.board.rows()),
       .next_step = hint ? hintText(*hint, survey.board)
                         : "check that the board is in the image, is sharp and has a white margin; " +
                               std::string(has_debug_flag ? "" : "alidade detect ") +
                               "--debug FOLDER saves copies of the images with the detections drawn in"});
}

void checkDebugFolder(const std::string& folder, const std::string& output) {
  const auto normal = [](const std::string& path) {
    std::error_code ignored;
    const std::filesystem::path whole = std::filesystem::absolute(path, ignored).lexically_normal();
    return whole.has_filename() ? whole : whole.parent_path();
  };
  if (folder.empty() || output.empty() || normal(folder) != normal(output)) return;
  throw usageError(
      {.where = "--debug " + folder, .found = "this is also the output", .expected = "a different folder"});
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

bool isCornersFile(const std::string& path) {
  return path.ends_with(".csv") || path.ends_with(".CSV");
}

GivenViews readViews(const ViewsRequest& request, const CommonOptions& options, const CancelFlag* cancel) {
  return isCornersFile(request.inputs.front()) ? readCorners(request) : findBoards(request, options, cancel);
}

}  // namespace alidade
