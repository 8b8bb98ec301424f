// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/corner_noise.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "alidade/core/median.h"

namespace alidade {
namespace {

// Corners with a larger stated sigma carry no information; the limit keeps the weights within a range that
// the solver can sum.
constexpr double kMaxSigmaPx = 100;

struct Residual {
  double stated_variance;  // px^2
  double squared_error;    // dx^2 + dy^2, px^2
  double redundancy;       // share of a coordinate's variance that the fit leaves in its error
};

// Derivative of the restricted likelihood by tau^2 (times 2): positive if the errors require more variance.
// The squared errors of clean corners over their variance follow chi^2 with two degrees of freedom. 14 % of
// them exceed the clip, and the clipped mean is 2 (1 - exp(-clip / 2)).
double likelihoodSlope(std::span<const Residual> residuals, double unexplained_variance) {
  constexpr double kClip = 4;
  const double mean = 2 * (1 - std::exp(-kClip / 2));
  double slope = 0;
  for (const Residual& r : residuals) {
    const double variance = r.stated_variance + unexplained_variance;
    const double expected = variance * r.redundancy;
    slope += r.redundancy / variance * (std::min(kClip, r.squared_error / expected) - mean);
  }
  return slope;
}

double findUnexplainedVariance(std::span<const Residual> residuals) {
  if (residuals.empty() || !(likelihoodSlope(residuals, 0) > 0)) return 0;
  double low = 0;
  double high = kMinSigmaPx * kMinSigmaPx;
  while (likelihoodSlope(residuals, high) > 0) {
    low = high;
    high *= 4;
  }
  constexpr int kHalvings = 30;  // to 1e-9 of the bracket, far below the precision of the estimate
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (likelihoodSlope(residuals, middle) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

CornerNoise::CornerNoise(std::span<const double> sigmas_px) {
  std::vector<double> known;
  for (const double sigma : sigmas_px) {
    if (!std::isnan(sigma)) known.push_back(std::clamp(sigma, kMinSigmaPx, kMaxSigmaPx));
  }
  is_stated_ = !known.empty();
  if (!is_stated_) return;
  const auto [least, most] = std::minmax_element(known.begin(), known.end());
  is_uniform_ = *least == *most;
  typical_sigma_px_ = medianOf(std::move(known));
}

void CornerNoise::estimateUnexplained(std::span<const CornerResidual> corners) {
  constexpr double kMinRedundancy = 1e-3;  // below, the fit passes through the corner regardless of its noise
  std::vector<Residual> residuals;
  std::vector<double> stated;
  for (const CornerResidual& corner : corners) {
    stated.push_back(statedVariance(corner.sigma_px));
    const double redundancy = 1 - 0.5 * corner.leverage;
    if (!(redundancy > kMinRedundancy) || !corner.error_px.allFinite()) continue;
    residuals.push_back({stated.back(), corner.error_px.squaredNorm(), redundancy});
  }
  unexplained_variance_ = findUnexplainedVariance(residuals);
  double sum = 0;
  for (const double variance : stated) sum += 1 / (variance + unexplained_variance_);
  reference_variance_ = static_cast<double>(stated.size()) / sum;
  is_estimated_ = true;
}

double CornerNoise::statedVariance(double sigma_px) const {
  const double sigma =
      std::isnan(sigma_px) ? typical_sigma_px_ : std::clamp(sigma_px, kMinSigmaPx, kMaxSigmaPx);
  return sigma * sigma;
}

double CornerNoise::weight(double sigma_px) const {
  if (is_uniform_ || !is_estimated_) return 1.0;
  return reference_variance_ / (statedVariance(sigma_px) + unexplained_variance_);
}

double CornerNoise::unexplainedSigma() const {
  return std::sqrt(unexplained_variance_);
}

}  // namespace alidade
