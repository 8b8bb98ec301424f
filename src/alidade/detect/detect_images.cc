// SPDX-License-Identifier: MIT
#include "alidade/detect/detect_images.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"

namespace alidade {

void useOneThreadPerImage() {
  cv::setNumThreads(1);
}

namespace {

void refuseAsUnreadable(const Error& error, ImageOutcome& outcome) {
  outcome.detection = {};
  outcome.detection.reason = DetectionReason::kUnreadable;
  outcome.detection.detail = error.what();
}

// The outcome for each board; the image is loaded into `source`.
std::vector<ImageOutcome> searched(const std::string& image,
                                   const std::function<LoadedImage(const std::string&)>& load,
                                   std::span<const Board> boards, LoadedImage& source) {
  std::vector<ImageOutcome> outcomes(boards.size());
  for (ImageOutcome& outcome : outcomes) outcome.image = image;
  try {
    source = load(image);
  } catch (const Error& error) {
    for (ImageOutcome& outcome : outcomes) refuseAsUnreadable(error, outcome);
    return outcomes;
  }
  for (std::size_t b = 0; b < boards.size(); ++b) {
    outcomes[b].size = source.image.size;
    outcomes[b].exif_orientation = source.exif_orientation;
    try {
      outcomes[b].detection = findBoard(source.image, boards[b]);
    } catch (const Error& error) {
      refuseAsUnreadable(error, outcomes[b]);
    }
  }
  return outcomes;
}

}  // namespace

std::vector<ImageOutcome> detectInImages(std::span<const std::string> images,
                                         const std::function<LoadedImage(const std::string&)>& load,
                                         const Board& board, const DetectImagesOptions& options) {
  return std::move(detectInImages(images, load, std::span(&board, 1), options).front());
}

std::vector<std::vector<ImageOutcome>> detectInImages(
    std::span<const std::string> images, const std::function<LoadedImage(const std::string&)>& load,
    std::span<const Board> boards, const DetectImagesOptions& options) {
  std::vector<std::vector<ImageOutcome>> outcomes(boards.size(), std::vector<ImageOutcome>(images.size()));
  std::mutex mutex;
  std::size_t num_done = 0;
  parallelFor(
      images.size(), options.num_jobs,
      [&](std::size_t i) {
        LoadedImage source;
        std::vector<ImageOutcome> of_boards = searched(images[i], load, boards, source);
        if (options.inspect && std::ranges::any_of(of_boards, &ImageOutcome::isReadable))
          options.inspect(source.image, of_boards);
        for (std::size_t b = 0; b < boards.size(); ++b) outcomes[b][i] = std::move(of_boards[b]);
        const std::lock_guard lock(mutex);
        ++num_done;
        if (options.progress) options.progress(num_done, images.size());
      },
      options.cancel);
  return outcomes;
}

}  // namespace alidade
