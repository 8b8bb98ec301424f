// SPDX-License-Identifier: MIT
#include "alidade/simulate/surface_texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace alidade {
namespace {

using Eigen::Vector2d;

// Root mean square of the change over a step, and the spread of the levels.
struct TextureStatistics {
  double step = 0;
  double spread = 0;
  double low = 255;
  double high = 0;
};

TextureStatistics measure(std::uint32_t seed, double footprint_m, double step_m) {
  constexpr int kCount = 4000;
  const SurfaceTexture texture(seed);
  double sum = 0;
  double sum2 = 0;
  TextureStatistics result;
  for (int i = 0; i < kCount; ++i) {
    const Vector2d p(0.0371 * i, 0.0173 * i - 3);
    const double level = texture.levelAt(p, footprint_m);
    const double change = texture.levelAt(p + Vector2d(step_m, 0), footprint_m) - level;
    sum += level;
    sum2 += level * level;
    result.step += change * change;
    result.low = std::min(result.low, level);
    result.high = std::max(result.high, level);
  }
  result.step = std::sqrt(result.step / kCount);
  result.spread = std::sqrt(sum2 / kCount - sum * sum / (kCount * static_cast<double>(kCount)));
  return result;
}

TEST(SurfaceTexture, HasDetailAtAllScalesButNotBelowTheFootprint) {
  int num_checked = 0;
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    for (const double footprint : {1e-4, 1e-3, 1e-2, 0.05}) {
      const TextureStatistics fine = measure(seed, footprint, 0.25 * footprint);
      const TextureStatistics coarse = measure(seed, footprint, 4 * footprint);
      EXPECT_GT(coarse.step, 8) << seed << " " << footprint;
      EXPECT_LT(fine.step, 0.4 * coarse.step) << seed << " " << footprint;
      EXPECT_GE(fine.low, 4);
      EXPECT_LE(fine.high, 252);
      ++num_checked;
    }
    // Finer than any detail that is left.
    const TextureStatistics far = measure(seed, 5, 1);
    EXPECT_LT(far.high - far.low, 1e-9);
    EXPECT_GT(measure(seed, 1e-3, 1).spread, 15);
  }
  EXPECT_EQ(num_checked, 24);
}

// The correlation of a patch with others, and of the patches at one place of two textures.
TEST(SurfaceTexture, DoesNotRepeat) {
  constexpr int kSide = 24;
  constexpr double kStep = 0.01;
  const auto correlation = [](const SurfaceTexture& a, const Vector2d& at_a, const SurfaceTexture& b,
                              const Vector2d& at_b) {
    double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vector2d offset(kStep * (i % kSide), kStep * (i / kSide));
      const double x = a.levelAt(at_a + offset, kStep);
      const double y = b.levelAt(at_b + offset, kStep);
      sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y;
    }
    const double n = kSide * kSide;
    return (sab - sa * sb / n) / std::sqrt((saa - sa * sa / n) * (sbb - sb * sb / n));
  };
  const SurfaceTexture texture(3);
  const Vector2d here(1.234, -0.77);
  EXPECT_NEAR(correlation(texture, here, texture, here), 1, 1e-9);
  int num_checked = 0;
  for (int i = 1; i <= 60; ++i) {
    const Vector2d there = here + Vector2d(0.5 * i, 0.25 * (i % 7));
    EXPECT_LT(std::abs(correlation(texture, here, texture, there)), 0.7) << i;
    EXPECT_LT(std::abs(correlation(texture, here, SurfaceTexture(static_cast<std::uint32_t>(100 + i)), here)),
              0.7)
        << i;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 60);
}

}  // namespace
}  // namespace alidade
