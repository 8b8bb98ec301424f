// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/saddle_corner.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace alidade {
namespace {

constexpr int kNumTerms = 11;  // 1, x, y, x^2 / 2, x y, y^2 / 2, and the five terms of fourth order
using Terms = Eigen::Matrix<double, kNumTerms, 1>;
using TermMatrix = Eigen::Matrix<double, kNumTerms, kNumTerms>;

// Weighted sums over the window's pixels.
struct Sums {
  TermMatrix weighted = TermMatrix::Zero();        // weight
  TermMatrix weighted_twice = TermMatrix::Zero();  // weight squared
  Terms right = Terms::Zero();
  double square = 0;
  double weight = 0;
  int count = 0;
};

Sums sumAbout(const GrayImage& image, const Eigen::Vector2d& center, double radius_px) {
  Sums sums;
  const int x0 = static_cast<int>(std::ceil(std::max(0.0, center.x() - radius_px)));
  const int x1 = static_cast<int>(std::floor(std::min(image.size.width - 1.0, center.x() + radius_px)));
  const int y0 = static_cast<int>(std::ceil(std::max(0.0, center.y() - radius_px)));
  const int y1 = static_cast<int>(std::floor(std::min(image.size.height - 1.0, center.y() + radius_px)));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double dx = x - center.x();
      const double dy = y - center.y();
      const double share = (dx * dx + dy * dy) / (radius_px * radius_px);
      if (share > 1) continue;
      const double weight = std::exp(-2 * share);
      const double grey = image.at(x, y);
      const double x2 = dx * dx;
      const double y2 = dy * dy;
      Terms terms;
      terms << 1, dx, dy, 0.5 * dx * dx, dx * dy, 0.5 * dy * dy, x2 * x2, x2 * dx * dy, x2 * y2, y2 * dx * dy,
          y2 * y2;
      sums.weighted.noalias() += weight * terms * terms.transpose();
      sums.weighted_twice.noalias() += weight * weight * terms * terms.transpose();
      sums.right += weight * grey * terms;
      sums.square += weight * grey * grey;
      sums.weight += weight;
      ++sums.count;
    }
  }
  return sums;
}

// The saddle of the grey levels near a corner.
struct Saddle {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance;    // px^2
  Eigen::Matrix2d curvature;     // second derivatives of the grey level, 1/px^2
  double residual_variance = 0;  // of the grey levels around the polynomial, squared grey levels
};

// Fits a polynomial to the grey levels within `radius_px` (weights fall to exp(-2) there) and moves to its
// saddle until convergence. It is for squares of a few pixels, and for blur that leaves no straight edges.
// Nothing if there is no saddle within `max_move_px` of `start`, or too little of its window is in the image.
//
// An X-corner looks the same after half a turn, so the polynomial has all terms of second and fourth order,
// and its terms of first order alone measure the offset of the corner. Residuals count as noise.
std::optional<Saddle> findSaddle(const GrayImage& image, const Eigen::Vector2d& start, double radius_px,
                                 double max_move_px) {
  constexpr int kMaxIterations = 12;
  constexpr int kMinPixels = 18;
  constexpr double kRestPx = 3e-3;
  constexpr double kMaxUnrestPx = 0.03;        // pixels that enter and leave at the rim may prevent
                                               // convergence
  constexpr double kLeastVariance = 1.0 / 12;  // rounding to whole grey levels
  Saddle saddle;
  saddle.pixel = start;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Sums sums = sumAbout(image, saddle.pixel, radius_px);
    if (sums.count < kMinPixels) return std::nullopt;
    const TermMatrix inverse = sums.weighted.inverse();
    const Terms terms = inverse * sums.right;
    // The change of the slope with the position of the window is the mean curvature within it, that of the
    // plain quadratic.
    const Eigen::Matrix<double, 6, 1> quadratic =
        sums.weighted.topLeftCorner<6, 6>().ldlt().solve(sums.right.head<6>());
    saddle.curvature << quadratic(3), quadratic(4), quadratic(4), quadratic(5);
    if (!terms.allFinite() || !quadratic.allFinite() || !(saddle.curvature.determinant() < 0))
      return std::nullopt;
    const Eigen::Matrix2d to_shift = saddle.curvature.inverse();
    Eigen::Vector2d shift = -to_shift * terms.segment<2>(1);
    const double length = shift.norm();
    if (length > 0.5 * radius_px)
      shift *= 0.5 * radius_px / length;  // the polynomial is accurate only
                                          // nearby
    if (iteration > kMaxIterations / 2) shift *= 0.5;
    saddle.pixel += shift;
    if (!((saddle.pixel - start).norm() <= max_move_px)) return std::nullopt;
    const bool is_last = iteration + 1 == kMaxIterations;
    if (length > (is_last ? kMaxUnrestPx : kRestPx)) continue;
    // Weighted residuals are smaller than the variance by the share that the terms absorb.
    const double taken = (inverse * sums.weighted_twice).trace();
    const double left = std::max(0.0, sums.square - sums.right.dot(terms));
    saddle.residual_variance =
        std::max(kLeastVariance, left / std::max(0.1 * sums.weight, sums.weight - taken));
    const TermMatrix covariance = saddle.residual_variance * inverse * sums.weighted_twice * inverse;
    saddle.covariance = to_shift * covariance.block<2, 2>(1, 1) * to_shift.transpose();
    return saddle;
  }
  return std::nullopt;
}

}  // namespace

std::optional<CornerFit> fitSaddleCorner(const CornerTask& task, const Eigen::Vector2d& start) {
  constexpr double kRadiusShare = 0.45;
  constexpr double kMinRadiusPx = 2.7;
  constexpr double kMaxRadiusPx = 20;
  constexpr double kMaxSigmaShare = 0.05;
  // Grey levels bend less along the board's lines than between them; motion blur across both lines bends them
  // most.
  constexpr double kMaxBend = 1.5;
  const CornerGuess& guess = task.guess;
  const double reach = kMaxMoveShare * task.spacing;
  double radius_share = std::min(kRadiusShare, guess.clear_share);
  for (const std::size_t side : {0U, 1U, 2U, 3U}) radius_share = task.shareOnSide(side, radius_share);
  const auto saddle = findSaddle(task.image, start,
                                 std::clamp(radius_share * task.spacing, kMinRadiusPx, kMaxRadiusPx), reach);
  if (!saddle || !((saddle->pixel - guess.pixel).norm() <= reach)) return std::nullopt;
  const auto contrast = task.contrastOfSquares(saddle->pixel);
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
  // At the corner, the twist of the edge model is (2 / pi) (contrast / 2) sin^2 / s^2.
  fit.blur_px = task.crossing_sine * std::sqrt(std::abs(*contrast / twist) / std::numbers::pi);
  fit.contrast = *contrast;
  fit.window = radius_share;
  return fit;
}

}  // namespace alidade
