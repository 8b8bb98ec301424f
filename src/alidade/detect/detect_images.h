// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/detect/checkerboard_detector.h"

namespace alidade {

/// An image as a reader hands it over, with what the reader noticed about it.
struct SourceImage {
  GrayImage image;
  int exif_orientation = 1;  ///< 1 = upright; anything else was ignored, pixels are as stored
};

/// What came of one image.
struct ImageOutcome {
  std::string image;
  ImageSize size;
  int exif_orientation = 1;
  Detection detection;
  std::optional<std::size_t> same_as =
      std::nullopt;  ///< kDuplicate: index of the outcome that shows the same
};

struct DetectImagesOptions {
  int num_jobs = 0;                                        ///< threads; 0 = one per processor
  std::function<void(std::size_t, std::size_t)> progress;  ///< (done, total), from any thread, one at a time
  /// Called with each image that could be read, once it has been searched; from any thread, several at a
  /// time.
  std::function<void(const GrayImage&, const ImageOutcome&)> inspect;
  const CancelFlag* cancel = nullptr;
};

/// Tells OpenCV to use the calling thread alone. For programs that share images out over threads by
/// detectInImages(): more threads within each image would only get in each other's way. Process-wide.
void useOneThreadPerImage();

/// Loads and searches images in parallel; a thread holds one image at a time. The result is in the order of
/// `images`, whatever the number of threads. An image that `load` cannot read (Error) becomes an outcome with
/// reason kUnreadable; the others go on.
/// @throws Cancelled
[[nodiscard]] std::vector<ImageOutcome> detectInImages(
    std::span<const std::string> images, const std::function<SourceImage(const std::string&)>& load,
    const Checkerboard& board, const DetectImagesOptions& options = {});

}  // namespace alidade
