// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// Approximate position and shape of a disc before refinement. Pixels; (0, 0) is the centre of the top left
/// pixel.
struct DiscGuess {
  Eigen::Vector2d pixel;  ///< its centre, within a third of its radius
  Eigen::Matrix2d shape;  ///< symmetric, px^-2: (x - pixel)^T shape (x - pixel) = 1 on the rim
  double reach = 1.5;     ///< distance from the centre without other print, in radii
};

/// An ellipse whose rim follows the edge of a disc.
struct DiscFit {
  Eigen::Vector2d pixel;  ///< its centre
  Eigen::Matrix2d shape;  ///< see DiscGuess
  double sigma_px = 0;    ///< of the centre, one standard deviation per axis: sqrt(trace(covariance) / 2)
  double blur_px = 0;     ///< one standard deviation of the edge's blur, including the pixel's own width
  double contrast = 0;    ///< grey levels outside minus inside
};

/// Fits DiscModel to the pixels around the rim, by Levenberg and Marquardt's method. The image of a disc is
/// an ellipse through a pinhole and nearly one through any lens. Blur and contrast move its rim equally on
/// both sides, so its centre is the centroid of the disc's image. The covariance follows from the scatter of
/// sections of the rim around the ellipse, so it includes noise that is correlated over a few pixels.
///
/// Nothing if there is no disc: the contrast is lost in the noise or missing on a part of the rim, the fit
/// moves away from the guess, or too few pixels remain.
[[nodiscard]] std::optional<DiscFit> fitDisc(const GrayImage& image, const DiscGuess& guess);

}  // namespace alidade
