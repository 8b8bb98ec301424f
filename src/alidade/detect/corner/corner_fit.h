// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/core/image.h"
#include "alidade/detect/corner/corner_task.h"

namespace alidade {

/// Refines the corners of checkerboards. An object keeps its buffers from corner to corner; each thread needs
/// its own. The result depends on the arguments alone.
class CornerFitter {
 public:
  /// Nothing where there is no X-corner, or it cannot be decided: the contrast is lost in the noise or
  /// missing on one of the four arms, the lines are not the guess' ones, or the fit leads away from the guess
  /// by more than 0.35 steps.
  [[nodiscard]] std::optional<CornerFit> fit(const GrayImage& image, const CornerGuess& guess);

 private:
  EdgePixels pixels_;
  EdgeResiduals residuals_;
};

}  // namespace alidade
