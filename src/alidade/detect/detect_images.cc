// SPDX-License-Identifier: MIT
#include "alidade/detect/detect_images.h"

#include <algorithm>
#include <mutex>
#include <utility>
#include <variant>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/detect/board/find_board.h"
#include "alidade/detect/detection_entry.h"
#include "alidade/files/content_cache.h"
#include "alidade/imagery/opencv_versions.h"

namespace alidade {

Detection findBoard(const GrayImage& image, const Board& board) {
  return std::visit([&](const auto& kind) { return findBoard(image, kind); }, board.kind());
}

void useOneThreadPerImage() {
  detail::useOneThread();
}

namespace {

void checkName(const std::string& name) {
  if (name.find_first_of("\r\n") == std::string::npos) return;
  throw inputError({.where = name,
                    .found = "a line break in the name",
                    .expected = "a name without line breaks, because corners files have one line per corner",
                    .next_step = "rename it"});
}

// The outcome for each board. The image is decoded into `source` if the cache does not have all of them.
std::vector<ImageOutcome> outcomesOf(const EncodedImage& image, std::span<const Board> boards,
                                     const DetectImagesOptions& options, LoadedImage& source) {
  const ContentCache* const cache = image.identity.empty() ? nullptr : options.cache;
  std::vector<std::optional<ImageOutcome>> known(boards.size());
  for (std::size_t b = 0; b < boards.size() && cache != nullptr; ++b) {
    const std::string key = entryKey(image.identity, boards[b]);
    const std::optional<std::string> text = cache->find(key);
    if (text) known[b] = parseEntry(*text, boards[b]);
    if (text && !known[b]) cache->reject(key);
  }
  if (options.inspect || !std::ranges::all_of(known, &std::optional<ImageOutcome>::has_value))
    source = image.decode();
  std::vector<ImageOutcome> outcomes;
  for (std::size_t b = 0; b < boards.size(); ++b) {
    if (known[b]) {
      outcomes.push_back(std::move(*known[b]));
      continue;
    }
    outcomes.push_back({.size = source.image.size,
                        .exif_orientation = source.exif_orientation,
                        .detection = findBoard(source.image, boards[b])});
    if (cache != nullptr) cache->keep(entryKey(image.identity, boards[b]), entryText(outcomes[b]));
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
    outcomes.assign(boards.size(),
                    {.detection = {.reason = DetectionReason::kUnreadable, .detail = error.what()}});
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
