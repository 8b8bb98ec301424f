// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// Where the grey levels about a corner have their saddle.
struct Saddle {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance;    ///< px^2
  Eigen::Matrix2d curvature;     ///< second derivatives of the grey level, 1/px^2
  double residual_variance = 0;  ///< of the grey levels about the polynomial, squared grey levels
};

/// Fits a polynomial to the grey levels within `radius_px` (weights fall to exp(-2) there) and moves to its
/// saddle until it rests. For squares of a few pixels, and for blur that leaves no straight edges. Nothing if
/// there is no saddle within `max_move_px` of `start`, or too little of its window lies in the image.
///
/// About an X-corner the pattern is the same when turned by half a circle, so the polynomial has all terms of
/// second and fourth order, and those of first order alone say how far the corner is off. What it leaves
/// counts as noise.
[[nodiscard]] std::optional<Saddle> findSaddle(const GrayImage& image, const Eigen::Vector2d& start,
                                               double radius_px, double max_move_px);

}  // namespace alidade
