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

// In standard errors of the mean and of the standard deviation over the sets: 0.12 and 0.08 at 1000 sets.
constexpr double kMaxSpreads = 3.7;

// Errors divided by the reported sigma must be standard normal: that is what a sigma says.
void expectTrueSigmas(const char* model, const std::vector<double>& truth, int num_sets) {
  const AnyCamera camera = AnyCamera::make(model, truth);
  std::vector<std::vector<double>> scores(static_cast<std::size_t>(num_sets));
  parallelFor(scores.size(), 0, [&](std::size_t i) {
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
    ASSERT_EQ(count, num_sets) << "every set converges";
    const double mean = sum / count;
    const double std = std::sqrt(sum2 / count - mean * mean);
    const std::string name(camera.parameterNames()[k]);
    std::printf("%-8s %-3s mean %+.3f  std %.3f\n", model, name.c_str(), mean, std);
    EXPECT_LE(std::abs(mean), kMaxSpreads / std::sqrt(count)) << name;
    EXPECT_LE(std::abs(std - 1), kMaxSpreads / std::sqrt(2.0 * count)) << name;
  }
}

TEST(Sigmas, AreTrueForRadtan) {
  expectTrueSigmas("radtan", {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01}, 1000);
}

// Its own formula in the same solver: a sigma wrong by a sixth is found, with radtan one by a twelfth.
TEST(Sigmas, AreTrueForPinhole) {
  expectTrueSigmas("pinhole", {1003, 1001, 645, 475}, 250);
}

}  // namespace
}  // namespace alidade
