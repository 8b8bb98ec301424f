// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/parallel.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr int kNumSets = 1000;
// The spread of a mean over 1000 sets is 0.032 and that of a standard deviation 0.022: these are 3.6 and more
// of them.
constexpr double kMaxMean = 0.12;
constexpr double kMinStd = 0.92;
constexpr double kMaxStd = 1.08;

// Errors divided by the reported sigma must be standard normal: that is what a sigma says.
void expectTrueSigmas(const char* model, const std::vector<double>& truth) {
  const AnyCamera camera = AnyCamera::make(model, truth);
  std::vector<std::vector<double>> scores(kNumSets);
  parallelFor(kNumSets, 0, [&](std::size_t i) {
    const SimulatedSet set = simulateSet(camera, kQuadVga, 12, 0.2, streamSeed(11, i));
    const Calibration result = calibrate(set.board, set.views, {.model = model});
    if (result.fit.summary.termination != Termination::kConverged || !result.uncertainty.covariance) return;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      scores[i].push_back((onlyCamera(result.fit).params[k] - truth[k]) /
                          result.uncertainty.parameterStdByNoise(static_cast<int>(k)));
    }
  });
  for (std::size_t k = 0; k < truth.size(); ++k) {
    double sum = 0;
    double sum2 = 0;
    int count = 0;
    for (const auto& set : scores) {
      if (set.size() != truth.size()) continue;
      sum += set[k];
      sum2 += set[k] * set[k];
      ++count;
    }
    ASSERT_EQ(count, kNumSets) << "every set converges";
    const double mean = sum / count;
    const double std = std::sqrt(sum2 / count - mean * mean);
    const std::string name(camera.parameterNames()[k]);
    std::printf("%-8s %-3s mean %+.3f  std %.3f\n", model, name.c_str(), mean, std);
    EXPECT_LE(std::abs(mean), kMaxMean) << name;
    EXPECT_GE(std, kMinStd) << name;
    EXPECT_LE(std, kMaxStd) << name;
  }
}

TEST(Sigmas, AreTrueForRadtan) {
  expectTrueSigmas("radtan", {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01});
}

TEST(Sigmas, AreTrueForPinhole) {
  expectTrueSigmas("pinhole", {1003, 1001, 645, 475});
}

}  // namespace
}  // namespace alidade
