// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/corner_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "alidade/core/random.h"

namespace alidade {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Corners with the errors of a fit that took nothing away.
struct Corners {
  std::vector<CornerResidual> all;

  void add(double stated_px, const Eigen::Vector2d& error) { all.push_back({stated_px, error, 0.0}); }
  [[nodiscard]] CornerNoise noise() const {
    std::vector<double> sigmas;
    for (const CornerResidual& corner : all) sigmas.push_back(corner.sigma_px);
    CornerNoise noise(sigmas);
    noise.estimateUnexplained(all);
    return noise;
  }
};

Eigen::Vector2d normalError(double sigma_px, Random& random) {
  const double dx = sigma_px * random.normal();
  return {dx, sigma_px * random.normal()};
}

// `true_sigma` of a corner that states sigma.
Corners simulate(int count, const std::vector<double>& stated, std::uint64_t seed,
                 const std::function<double(double)>& true_sigma) {
  Random random(seed);
  Corners corners;
  for (int i = 0; i < count; ++i) {
    const double sigma = stated[static_cast<std::size_t>(i) % stated.size()];
    corners.add(sigma, normalError(true_sigma(sigma), random));
  }
  return corners;
}

TEST(CornerNoise, UnknownOrEqualSigmasWeighExactlyOne) {
  const auto same = [](double) { return 0.1; };
  const CornerNoise unknown = simulate(100, {kUnknown}, 1, same).noise();
  EXPECT_FALSE(unknown.isStated());
  EXPECT_TRUE(unknown.isUniform());
  EXPECT_EQ(unknown.weight(kUnknown), 1.0);
  const CornerNoise equal = simulate(100, {0.07, 0.07, kUnknown}, 1, same).noise();
  EXPECT_TRUE(equal.isStated());
  EXPECT_TRUE(equal.isUniform());
  EXPECT_EQ(equal.weight(0.07), 1.0);
  EXPECT_EQ(equal.weight(kUnknown), 1.0);
}

TEST(CornerNoise, AnUnknownSigmaCountsAsTheMedian) {
  const CornerNoise noise =
      simulate(700, {0.02, 0.03, 0.05, 0.2, 0.3, kUnknown, kUnknown}, 1, [](double) { return 0.1; }).noise();
  EXPECT_EQ(noise.weight(kUnknown), noise.weight(0.05));
  EXPECT_GT(noise.weight(kUnknown), noise.weight(0.2));
}

// Beyond the clip lie 14 % of clean corners; the variance of 4000 then scatters by 1.8 %.
TEST(CornerNoise, FindsWhatTheStatedSigmasLeave) {
  for (const double tau : {0.02, 0.1, 0.5}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const CornerNoise noise = simulate(4000, {0.01, 0.02, 0.05}, seed, [&](double sigma) {
                                  return std::hypot(sigma, tau);
                                }).noise();
      EXPECT_NEAR(noise.unexplainedSigma(), tau, 0.06 * tau);
      const double expected = (0.05 * 0.05 + tau * tau) / (0.01 * 0.01 + tau * tau);
      EXPECT_NEAR(noise.weight(0.01) / noise.weight(0.05), expected, 0.1 * expected);
    }
  }
}

TEST(CornerNoise, TrueOrOverstatedSigmasLeaveNothing) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const CornerNoise is_true = simulate(4000, {0.02, 0.2}, seed, [](double sigma) { return sigma; }).noise();
    EXPECT_LT(is_true.unexplainedSigma(), 0.006);
    EXPECT_NEAR(is_true.weight(0.02) / is_true.weight(0.2), 100, 9);
    const CornerNoise too_wide =
        simulate(4000, {0.02, 0.2}, seed, [](double sigma) { return sigma / 2; }).noise();
    EXPECT_EQ(too_wide.unexplainedSigma(), 0);
    EXPECT_NEAR(too_wide.weight(0.02) / too_wide.weight(0.2), 100, 1e-9);
  }
}

TEST(CornerNoise, TheMeanWeightIsOne) {
  const std::vector<double> stated = {0.01, 0.05, 0.3, kUnknown};
  const CornerNoise noise = simulate(400, stated, 3, [](double) { return 0.1; }).noise();
  double sum = 0;
  for (const double sigma : stated) sum += noise.weight(sigma);
  EXPECT_NEAR(sum / 4, 1, 1e-12);
}

TEST(CornerNoise, OutliersHaveABoundedSay) {
  Corners corners = simulate(2000, {0.02, 0.03}, 4, [](double sigma) { return std::hypot(sigma, 0.1); });
  for (std::size_t i = 0; i < 100; ++i) corners.all[20 * i].error_px = {30, 1e4};
  EXPECT_NEAR(corners.noise().unexplainedSigma(), 0.1, 0.01);
}

// A fit that runs through half of the corners leaves half of their variance.
TEST(CornerNoise, AllowsForWhatTheFitTookAway) {
  Corners corners =
      simulate(4000, {0.02, 0.03}, 5, [](double sigma) { return std::hypot(sigma, 0.1) * std::sqrt(0.5); });
  EXPECT_NEAR(corners.noise().unexplainedSigma(), 0.067, 0.004);
  for (CornerResidual& corner : corners.all) corner.leverage = 1.0;
  EXPECT_NEAR(corners.noise().unexplainedSigma(), 0.1, 0.006);
}

TEST(CornerNoise, SigmasOfNothingAndWithoutBoundKeepWeightsFinite) {
  const double infinity = std::numeric_limits<double>::infinity();
  const CornerNoise noise = simulate(300, {0.0, 0.1, infinity}, 6, [](double) { return 0.0; }).noise();
  EXPECT_EQ(noise.unexplainedSigma(), 0);
  EXPECT_EQ(noise.weight(0.0), noise.weight(kMinSigmaPx));
  EXPECT_GT(noise.weight(infinity), 0);
  EXPECT_LT(noise.weight(0.0), 4);
}

}  // namespace
}  // namespace alidade
