// SPDX-License-Identifier: MIT
#include "detection_stage.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "alidade/calibrate/size_groups.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/detect/board_hint.h"
#include "alidade/io/image_file.h"
#include "alidade/io/image_list.h"
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

// An error's message, which has a line of its own for the next step, in a single line.
std::string oneLine(std::string text) {
  constexpr std::string_view kNextLine = "\n  next: ";
  for (std::size_t at = text.find(kNextLine); at != std::string::npos; at = text.find(kNextLine, at))
    text.replace(at, kNextLine.size(), "; next: ");
  for (char& c : text) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return text;
}

// Names as short as they can be while telling the images apart: paths without the folders that all share.
std::vector<std::string> shortNames(const std::vector<std::string>& paths) {
  const std::string& first = paths.front();
  std::size_t shared = first.rfind('/') == std::string::npos ? 0 : first.rfind('/') + 1;
  for (const std::string& path : paths) {
    while (shared > 0 && path.compare(0, shared, first, 0, shared) != 0) {
      const std::size_t slash = shared < 2 ? std::string::npos : first.rfind('/', shared - 2);
      shared = slash == std::string::npos ? 0 : slash + 1;
    }
  }
  std::vector<std::string> names;
  for (const std::string& path : paths) names.push_back(path.substr(shared));
  return names;
}

void markOtherSizes(DetectionStage& stage) {
  std::vector<ImageSize> sizes;
  std::vector<std::size_t> readable;
  for (std::size_t i = 0; i < stage.outcomes.size(); ++i) {
    if (stage.outcomes[i].detection.reason == DetectionReason::kUnreadable) continue;
    sizes.push_back(stage.outcomes[i].size);
    readable.push_back(i);
  }
  const SizeGroups groups = groupBySize(sizes);
  for (const std::size_t k : groups.others) {
    ImageOutcome& outcome = stage.outcomes[readable[k]];
    outcome.detection.reason = DetectionReason::kOtherSize;
    outcome.detection.detail =
        fmt::format("is {}, while most images are {}", sizeText(outcome.size), sizeText(groups.size));
    outcome.detection.corners.clear();
  }
  if (!groups.others.empty()) {
    stage.notes.push_back(fmt::format("images of {} sizes were given; the {} of {} are used",
                                      groups.others.size() == 1 ? "two" : "several", groups.in_group.size(),
                                      sizeText(groups.size)));
  }
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

[[noreturn]] void throwNoBoard(const DetectionStage& stage, const std::vector<std::string>& paths,
                               const DetectImagesOptions& options) {
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
  const std::string size = fmt::format("{}x{}", stage.board.columns, stage.board.rows);
  std::string next = "check that the whole board is in the image, sharp, and with a white margin";
  if (const auto hint = guessBoardSize(paths, loadImage, stage.board, options)) {
    next = fmt::format(
        "{} of {} images looked at show {}x{} inner corners; did you count squares? Use {}", hint->num_images,
        hint->num_looked_at, hint->columns, hint->rows,
        specText({.columns = hint->columns, .rows = hint->rows, .square_m = stage.board.square_m}));
  }
  throw inputError({.where = paths.size() == 1 ? paths.front() : fmt::format("{} images", paths.size()),
                    .found = fmt::format("no board ({})", join(reasons, ", ")),
                    .expected = "a checkerboard of " + size + " inner corners (columns x rows)",
                    .next_step = next});
}

}  // namespace

std::size_t DetectionStage::numFound() const {
  return static_cast<std::size_t>(std::count_if(outcomes.begin(), outcomes.end(),
                                                [](const ImageOutcome& o) { return o.detection.found(); }));
}

DetectionStage runDetection(const std::vector<std::string>& inputs, const Checkerboard& board,
                            const CommonOptions& options, const CancelFlag* cancel) {
  const std::vector<std::string> paths = listImages(inputs);
  DetectionStage stage;
  stage.board = board;
  DetectImagesOptions detect_options;
  detect_options.num_jobs = options.jobs;
  detect_options.cancel = cancel;
  {
    ProgressBar bar("finding boards", options.quiet);
    detect_options.progress = [&bar](std::size_t done, std::size_t total) { bar.update(done, total); };
    stage.outcomes = detectInImages(paths, loadImage, board, detect_options);
  }
  const std::vector<std::string> names = shortNames(paths);
  for (std::size_t i = 0; i < names.size(); ++i) stage.outcomes[i].image = names[i];
  markOtherSizes(stage);
  noteOrientations(stage);
  for (const ImageOutcome& outcome : stage.outcomes) {
    if (outcome.detection.found())
      stage.views.push_back({outcome.image, outcome.size, outcome.detection.corners});
  }
  if (stage.views.empty()) throwNoBoard(stage, paths, detect_options);
  return stage;
}

std::vector<std::string> reasonLines(const DetectionStage& stage) {
  std::vector<std::string> lines;
  for (const ImageOutcome& outcome : stage.outcomes) {
    if (outcome.detection.found()) continue;
    lines.push_back(oneLine(fmt::format("{}: {}: {}", outcome.image, reasonCode(outcome.detection.reason),
                                        outcome.detection.detail)));
  }
  return lines;
}

}  // namespace alidade
