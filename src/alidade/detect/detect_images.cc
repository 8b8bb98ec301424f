// SPDX-License-Identifier: MIT
#include "alidade/detect/detect_images.h"

#include <mutex>

#include <opencv2/core/utility.hpp>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"

namespace alidade {

void useOneThreadPerImage() {
  cv::setNumThreads(1);
}

std::vector<ImageOutcome> detectInImages(std::span<const std::string> images,
                                         const std::function<LoadedImage(const std::string&)>& load,
                                         const Board& board, const DetectImagesOptions& options) {
  std::vector<ImageOutcome> outcomes(images.size());
  std::mutex mutex;
  std::size_t num_done = 0;
  parallelFor(
      images.size(), options.num_jobs,
      [&](std::size_t i) {
        ImageOutcome& outcome = outcomes[i];
        outcome.image = images[i];
        LoadedImage source;
        try {
          source = load(images[i]);
          outcome.size = source.image.size;
          outcome.exif_orientation = source.exif_orientation;
          outcome.detection = findBoard(source.image, board);
        } catch (const Error& error) {
          outcome.detection = {};
          outcome.detection.reason = DetectionReason::kUnreadable;
          outcome.detection.detail = error.what();
        }
        if (options.inspect && outcome.detection.reason != DetectionReason::kUnreadable)
          options.inspect(source.image, outcome);
        const std::lock_guard lock(mutex);
        ++num_done;
        if (options.progress) options.progress(num_done, images.size());
      },
      options.cancel);
  return outcomes;
}

}  // namespace alidade
