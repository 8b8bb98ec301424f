// SPDX-License-Identifier: MIT
#include "alidade/detect/detect_images.h"

#include <algorithm>
#include <mutex>
#include <utility>
#include <variant>

#include <opencv2/core/utility.hpp>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/detect/board/april_grid_detector.h"
#include "alidade/detect/board/charuco_detector.h"
#include "alidade/detect/board/checkerboard_detector.h"
#include "alidade/detect/board/circle_grid_detector.h"
#include "alidade/detect/detection_entry.h"
#include "alidade/files/content_cache.h"

namespace alidade {

Detection findBoard(const GrayImage& image, const Board& board) {
  return std::visit([&](const auto& kind) { return findBoard(image, kind); }, board.kind());
}

void useOneThreadPerImage() {
  cv::setNumThreads(1);
}

namespace {

void checkName(const std::string& name) {
  if (name.find_first_of("\r\n") == std::string::npos) return;
  throw inputError({.where = name,
                    .found = "a line break in the name",
                    .expected = "a name without line breaks, because corners files have one line per corner",
                    .next_step = "rename it"});
}

// An image's outcomes for each board, where they are in the cache.
std::vector<std::optional<ImageOutcome>> knownOutcomes(const EncodedImage& image,
                                                       std::span<const Board> boards,
                                                       const ContentCache* cache) {
  std::vector<std::optional<ImageOutcome>> known(boards.size());
  if (cache == nullptr || image.identity.empty()) return known;
  for (std::size_t b = 0; b < boards.size(); ++b) {
    const std::string key = entryKey(image.identity, boards[b]);
    const std::optional<std::string> text = cache->find(key);
    if (!text) continue;
    known[b] = parseEntry(*text, boards[b]);
    if (!known[b]) cache->reject(key);
  }
  return known;
}

ImageOutcome searchedFor(const Board& board, const LoadedImage& source) {
  ImageOutcome outcome;
  outcome.size = source.image.size;
  outcome.exif_orientation = source.exif_orientation;
  try {
    outcome.detection = findBoard(source.image, board);
  } catch (const Error& error) {
    outcome.detection.reason = DetectionReason::kUnreadable;
    outcome.detection.detail = error.what();
  }
  return outcome;
}

// The outcome for each board. The image is decoded into `source` if that is needed.
std::vector<ImageOutcome> outcomesOf(const EncodedImage& image, std::span<const Board> boards,
                                     const DetectImagesOptions& options, LoadedImage& source) {
  std::vector<std::optional<ImageOutcome>> known = knownOutcomes(image, boards, options.cache);
  const bool are_known = std::ranges::all_of(known, [](const auto& outcome) { return outcome.has_value(); });
  if (!are_known || options.inspect) source = image.decode();
  std::vector<ImageOutcome> outcomes;
  for (std::size_t b = 0; b < boards.size(); ++b) {
    outcomes.push_back(known[b] ? std::move(*known[b]) : searchedFor(boards[b], source));
    if (options.cache != nullptr && !image.identity.empty() && !known[b] && outcomes[b].isReadable())
      options.cache->keep(entryKey(image.identity, boards[b]), entryText(outcomes[b]));
  }
  return outcomes;
}

std::vector<ImageOutcome> searched(const ImageSet& images, std::size_t i, std::span<const Board> boards,
                                   const DetectImagesOptions& options) {
  std::vector<ImageOutcome> outcomes;
  LoadedImage source;
  const std::string& name = images.name(i);
  try {
    checkName(name);
    outcomes = outcomesOf(images.read(i), boards, options, source);
  } catch (const Error& error) {
    ImageOutcome unreadable;
    unreadable.detection.reason = DetectionReason::kUnreadable;
    unreadable.detection.detail = error.what();
    outcomes.assign(boards.size(), unreadable);
  }
  for (ImageOutcome& outcome : outcomes) {
    outcome.image = name;
    outcome.sequence = images.sequenceOf(i);
  }
  if (options.inspect && std::ranges::any_of(outcomes, &ImageOutcome::isReadable))
    options.inspect(source.image, outcomes);
  return outcomes;
}

}  // namespace

std::vector<ImageOutcome> detectInImages(const ImageSet& images, const Board& board,
                                         const DetectImagesOptions& options) {
  return std::move(detectInImages(images, std::span(&board, 1), options).front());
}

std::vector<std::vector<ImageOutcome>> detectInImages(const ImageSet& images, std::span<const Board> boards,
                                                      const DetectImagesOptions& options) {
  std::vector<std::vector<ImageOutcome>> outcomes(boards.size(), std::vector<ImageOutcome>(images.size()));
  std::mutex mutex;
  std::size_t num_done = 0;
  parallelFor(
      images.size(), options.num_jobs,
      [&](std::size_t i) {
        std::vector<ImageOutcome> of_boards = searched(images, i, boards, options);
        for (std::size_t b = 0; b < boards.size(); ++b) outcomes[b][i] = std::move(of_boards[b]);
        const std::lock_guard lock(mutex);
        ++num_done;
        if (options.progress) options.progress(num_done, images.size());
      },
      options.cancel);
  return outcomes;
}

}  // namespace alidade
