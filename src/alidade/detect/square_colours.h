// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/detect/corner_fit.h"

namespace alidade {

/// Contrast as in CornerFit from one place in each of the four squares; nothing where they do not alternate.
[[nodiscard]] std::optional<double> contrastOfSquares(const GrayImage& image, const CornerGuess& guess,
                                                      const Eigen::Vector2d& corner);

/// True unless one of the four squares shows the other colour than the fit says, as where something covers it
/// or the pattern is none. Squares outside the image say nothing.
[[nodiscard]] bool haveColoursOfFit(const GrayImage& image, const CornerGuess& guess, const CornerFit& fit);

}  // namespace alidade
