// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/detect/detect_images.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"
#include "command.h"

namespace alidade {

/// What came of a set of images: the seam between the images and everything after.
struct DetectionStage {
  Checkerboard board;
  std::vector<ImageOutcome>
      outcomes;                    ///< in natural order; image names without the part that all paths share
  std::vector<View> views;         ///< of the images with a board and of the commonest size
  std::vector<std::string> notes;  ///< things noticed that are no failure of an image

  [[nodiscard]] std::size_t numFound() const;
};

/// Finds the board in all images that `inputs` stand for, with progress on a terminal. Images of another size
/// than most are marked so (kOtherSize) and give no view.
/// @throws Error (kInput) when there is no image, or no board in any; Cancelled
[[nodiscard]] DetectionStage runDetection(const std::vector<std::string>& inputs, const Checkerboard& board,
                                          const CommonOptions& options, const CancelFlag* cancel);

/// One line an image without a board, "name: why", for people.
[[nodiscard]] std::vector<std::string> reasonLines(const DetectionStage& stage);

}  // namespace alidade
