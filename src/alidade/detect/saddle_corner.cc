// SPDX-License-Identifier: MIT
#include "alidade/detect/saddle_corner.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "alidade/detect/saddle_fit.h"
#include "alidade/detect/square_colours.h"

namespace alidade {

std::optional<CornerFit> fitSaddleCorner(const CornerTask& task, const Eigen::Vector2d& start) {
  constexpr double kRadiusShare = 0.45;
  constexpr double kMinRadiusPx = 2.7;
  constexpr double kMaxRadiusPx = 20;
  constexpr double kMaxSigmaShare = 0.05;
  // Along the board's lines the grey levels bend less than between them; motion across both lines bends them
  // most.
  constexpr double kMaxBend = 1.5;
  const CornerGuess& guess = task.guess;
  const double reach = kMaxMoveShare * task.spacing;
  const auto saddle = findSaddle(task.image, start,
                                 std::clamp(kRadiusShare * task.spacing, kMinRadiusPx, kMaxRadiusPx), reach);
  if (!saddle || !((saddle->pixel - guess.pixel).norm() <= reach)) return std::nullopt;
  const auto contrast = contrastOfSquares(task.image, guess, saddle->pixel);
  if (!contrast || std::abs(*contrast) < kMinContrast ||
      *contrast * *contrast < 4 * saddle->residual_variance)
    return std::nullopt;
  const Eigen::Vector2d u = guess.step_u.normalized();
  const Eigen::Vector2d v = guess.step_v.normalized();
  const double twist = u.dot(saddle->curvature * v);
  if (twist * *contrast >= 0 || std::abs(u.dot(saddle->curvature * u)) > kMaxBend * std::abs(twist) ||
      std::abs(v.dot(saddle->curvature * v)) > kMaxBend * std::abs(twist))
    return std::nullopt;
  CornerFit fit;
  fit.pixel = saddle->pixel;
  fit.covariance = saddle->covariance;
  fit.sigma_px = std::sqrt(0.5 * saddle->covariance.trace());
  if (!(fit.sigma_px <= kMaxSigmaShare * task.spacing)) return std::nullopt;
  // At the corner the edge model's twist is (2 / pi) (contrast / 2) sin^2 / s^2.
  fit.blur_px = task.crossing_sine * std::sqrt(std::abs(*contrast / twist) / std::numbers::pi);
  fit.contrast = *contrast;
  fit.window = kRadiusShare;
  fit.method = CornerFitMethod::kSaddle;
  return fit;
}

}  // namespace alidade
