// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/detect/board/detection.h"
#include "alidade/imagery/image_set.h"

namespace alidade {

/// Finds a complete or partly visible board in a grey image, and refines its corners (CornerFitter).
[[nodiscard]] Detection findBoard(const GrayImage& image, const Board& board);

struct DetectImagesOptions {
  int num_jobs = 0;                                        ///< threads; 0 = one per processor
  std::function<void(std::size_t, std::size_t)> progress;  ///< (done, total); any thread, one call at a time
  /// Called with each readable image and the outcome for each board after the search, from any thread and
  /// possibly concurrently.
  std::function<void(const GrayImage&, std::span<const ImageOutcome>)> inspect;
  const CancelFlag* cancel = nullptr;
  const ContentCache* cache = nullptr;  ///< of outcomes
};

/// Makes OpenCV use only the calling thread. For programs that distribute images over threads by
/// detectInImages(): more threads per image would only compete. It applies to the whole process.
void useOneThreadPerImage();

/// Reads and searches images in parallel; a thread holds one image at a time. The result is one list of
/// outcomes for each board, in the order of `images`, regardless of the number of threads. An image that
/// cannot be read (Error) becomes an outcome with reason kUnreadable; the others are still processed. An
/// image is not decoded if all outcomes are in the cache, unless `inspect` is set.
/// @throws Cancelled
[[nodiscard]] std::vector<std::vector<ImageOutcome>> detectInImages(const ImageSet& images,
                                                                    std::span<const Board> boards,
                                                                    const DetectImagesOptions& options = {});

}  // namespace alidade
