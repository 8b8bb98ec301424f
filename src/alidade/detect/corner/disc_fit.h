// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// What is known of a disc before it is refined. Pixels; (0, 0) is the centre of the top left pixel.
struct DiscGuess {
  Eigen::Vector2d pixel;  ///< its middle, within a third of its radius
  Eigen::Matrix2d shape;  ///< symmetric, px^-2: (x - pixel)^T shape (x - pixel) = 1 on the rim
  double reach = 1.5;     ///< how far from the middle nothing else is printed, in radii
};

/// An ellipse whose rim follows the edge of a disc.
struct DiscFit {
  Eigen::Vector2d pixel;  ///< its middle
  Eigen::Matrix2d shape;  ///< see DiscGuess
  double sigma_px = 0;    ///< of the middle, one standard deviation an axis: sqrt(trace(covariance) / 2)
  double blur_px = 0;     ///< one standard deviation of the edge's blur, the pixel's own width included
  double contrast = 0;    ///< grey levels outside less inside
};

/// Fits I(X, Y) = (1 + sx X + sy Y) (a + b erf(d / (sqrt2 s))) to the pixels about the rim, d being the
/// signed distance to an ellipse to first order (Sampson 1982, Fitting conic sections to very scattered
/// data): ten parameters, Levenberg and Marquardt. The image of a disc is an ellipse through a pinhole and
/// nearly one through any lens; blur and contrast move its rim alike on both sides, so its middle is the
/// centroid of the disc's image. The covariance is by the scatter of the rim about the ellipse in sections of
/// its circumference, which noise that goes together over some pixels raises.
///
/// Nothing where there is no disc: the contrast is lost in the noise or missing on a part of the rim, the fit
/// leads away from the guess, or too few pixels are left.
[[nodiscard]] std::optional<DiscFit> fitDisc(const GrayImage& image, const DiscGuess& guess);

}  // namespace alidade
