// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/core/image.h"
#include "alidade/detect/corner/corner_guess.h"
#include "alidade/detect/corner/edge_model.h"

namespace alidade {

/// Refines the corners of checkerboards. An object reuses its buffers; each thread needs its own. The result
/// depends only on the arguments.
class CornerFitter {
 public:
  /// Nothing if there is no X-corner or it cannot be decided: the contrast is lost in the noise or missing on
  /// one of the four arms, the lines differ from those of the guess, or the fit moves away from the guess by
  /// more than 0.35 steps.
  [[nodiscard]] std::optional<CornerFit> fit(const GrayImage& image, const CornerGuess& guess);

 private:
  EdgePixels pixels_;
  EdgeResiduals residuals_;
};

}  // namespace alidade
