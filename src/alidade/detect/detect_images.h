// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/detect/detection.h"
#include "alidade/imagery/image_file.h"

namespace alidade {

/// The outcome for one image and one board.
struct ImageOutcome {
  std::string image;
  ImageSize size;
  int exif_orientation = 1;
  Detection detection;
  std::optional<std::size_t> same_as =
      std::nullopt;  ///< kDuplicate: index of the outcome that shows the same

  [[nodiscard]] bool isReadable() const { return detection.reason != DetectionReason::kUnreadable; }
};

struct DetectImagesOptions {
  int num_jobs = 0;                                        ///< threads; 0 = one per processor
  std::function<void(std::size_t, std::size_t)> progress;  ///< (done, total); any thread, one call at a time
  /// Called with each readable image and the outcome for each board after the search, from any thread and
  /// possibly concurrently.
  std::function<void(const GrayImage&, std::span<const ImageOutcome>)> inspect;
  const CancelFlag* cancel = nullptr;
};

/// Makes OpenCV use only the calling thread. For programs that distribute images over threads by
/// detectInImages(): more threads per image would only compete. It applies to the whole process.
void useOneThreadPerImage();

/// Loads and searches images in parallel; a thread holds one image at a time. The result is in the order of
/// `images`, regardless of the number of threads. An image that `load` cannot read (Error) becomes an outcome
/// with reason kUnreadable; the others are still processed.
/// @throws Cancelled
[[nodiscard]] std::vector<ImageOutcome> detectInImages(
    std::span<const std::string> images, const std::function<LoadedImage(const std::string&)>& load,
    const Board& board, const DetectImagesOptions& options = {});

/// The same for several boards, each image loaded once: one list of outcomes for each board.
[[nodiscard]] std::vector<std::vector<ImageOutcome>> detectInImages(
    std::span<const std::string> images, const std::function<LoadedImage(const std::string&)>& load,
    std::span<const Board> boards, const DetectImagesOptions& options = {});

}  // namespace alidade
