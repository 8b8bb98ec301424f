// SPDX-License-Identifier: MIT
#include "alidade/simulate/point_spread.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "alidade/core/error.h"

namespace alidade {
namespace {

// Where pointSpreadShare() is `share`, by bisection; share in (0, 0.5].
double leftQuantile(double share, double blur_px) {
  if (blur_px == 0) return share - 0.5;
  double low = -0.5 - 10 * blur_px;  // the share there is below 1e-23
  double high = 0;
  constexpr int kNumBisections = 60;
  for (int i = 0; i < kNumBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (pointSpreadShare(middle, blur_px) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double pointSpreadShare(double x_px, double blur_px) {
  if (blur_px == 0) return std::clamp(x_px + 0.5, 0.0, 1.0);
  // The integral of the normal distribution function; the share is its rise over the pixel's width.
  const auto integral = [blur_px](double t) {
    const double z = t / blur_px;
    const double density = std::exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    const double distribution = 0.5 * std::erfc(-z / std::numbers::sqrt2);
    return t * distribution + blur_px * density;
  };
  return integral(x_px + 0.5) - integral(x_px - 0.5);
}

PointSpread makePointSpread(double blur_px, int min_samples) {
  constexpr int kMaxSamples = 1'000'000;
  expect(blur_px >= 0, "a blur that is not negative");
  expect(min_samples >= 1 && min_samples <= kMaxSamples, "1 to 1e6 samples");
  std::int64_t generator = 1;
  std::int64_t count = 1;
  while (count < min_samples) {
    const std::int64_t next = generator + count;
    generator = count;
    count = next;
  }

  // Coordinate k of an axis is the quantile of (2 k + 1) / (2 count); the second half mirrors the first.
  std::vector<double> quantiles(static_cast<std::size_t>(count), 0.0);
  for (std::size_t k = 0; k < quantiles.size() / 2; ++k) {
    const double share = (static_cast<double>(k) + 0.5) / static_cast<double>(count);
    quantiles[k] = leftQuantile(share, blur_px);
    quantiles[quantiles.size() - 1 - k] = -quantiles[k];
  }

  PointSpread spread;
  // The offset of y puts the lattice point of index count - 1 - i opposite to that of i, and keeps the
  // numerator odd (of a generator and a count next to each other, at most one is even).
  const std::int64_t offset = generator + (generator % 2 == 0 ? count : 0);
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t numerator = (2 * i * generator + offset) % (2 * count);
    spread.x.push_back(quantiles[static_cast<std::size_t>(i)]);
    spread.y.push_back(quantiles[static_cast<std::size_t>(numerator / 2)]);
    spread.radius_px = std::max(spread.radius_px, std::hypot(spread.x.back(), spread.y.back()));
  }
  return spread;
}

}  // namespace alidade
