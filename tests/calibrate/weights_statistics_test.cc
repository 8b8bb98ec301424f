// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/core/parallel.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr int kNumSets = 500;
constexpr int kNumPlainSets = 60;
// The spread of a standard deviation over 500 sets is 0.032, so this is 3.2 of it.
constexpr double kMinStd = 0.9;
constexpr double kMaxStd = 1.1;
// Over 60 sets a scatter is known to 9 %. Noise of 0.02 px on half of the corners and ten times that on the
// rest leaves unweighted least squares 5.1 times the scatter of the weighted one; its robust loss, which
// takes the worst for outliers, somewhat less.
constexpr double kMinGain = 2.5;

// Half of the corners have ten times the noise of the others, and say so.
SimulatedSet mixedSet(const AnyCamera& camera, std::size_t i) {
  SimulatedSet set = simulateSet(camera, kQuadVga, 12, 0.0, streamSeed(21, i));
  Random random(streamSeed(22, i));
  for (View& view : set.views) {
    for (Corner& corner : view.corners) {
      corner.sigma_px = random.uniform() < 0.5 ? 0.02 : 0.2;
      corner.pixel.x() += corner.sigma_px * random.normal();
      corner.pixel.y() += corner.sigma_px * random.normal();
    }
  }
  return set;
}

TEST(Weights, ShrinkTheScatterAndKeepSigmasTrue) {
  const std::vector<double> truth = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
  const AnyCamera camera = AnyCamera::make("radtan", truth);
  std::vector<std::vector<double>> errors(kNumSets);
  std::vector<std::vector<double>> scores(kNumSets);
  std::vector<std::vector<double>> plain_errors(kNumPlainSets);
  parallelFor(kNumSets, 0, [&](std::size_t i) {
    SimulatedSet set = mixedSet(camera, i);
    const Calibration weighted = calibrate(set.board, set.views, {.model = "radtan"});
    if (weighted.fit.summary.termination != Termination::kConverged || !weighted.uncertainty.covariance)
      return;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      errors[i].push_back(onlyCamera(weighted.fit).params[k] - truth[k]);
      scores[i].push_back(errors[i].back() / weighted.uncertainty.parameterStdByNoise(static_cast<int>(k)));
    }
    if (i >= kNumPlainSets) return;
    for (View& view : set.views) {
      for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
    }
    const Calibration plain = calibrate(set.board, set.views, {.model = "radtan"});
    for (std::size_t k = 0; k < truth.size(); ++k) {
      plain_errors[i].push_back(onlyCamera(plain.fit).params[k] - truth[k]);
    }
  });
  const auto rms = [](const std::vector<std::vector<double>>& sets, std::size_t k, std::size_t count) {
    double sum2 = 0;
    for (std::size_t i = 0; i < count; ++i) sum2 += sets[i][k] * sets[i][k];
    return std::sqrt(sum2 / static_cast<double>(count));
  };
  for (const auto& set : scores) ASSERT_EQ(set.size(), truth.size()) << "every set converges";
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const std::string name(camera.parameterNames()[k]);
    const double score = rms(scores, k, kNumSets);
    const double gain = rms(plain_errors, k, kNumPlainSets) / rms(errors, k, kNumPlainSets);
    std::printf("weighted %-3s score %.3f  scatter without weights %.2f times as large\n", name.c_str(),
                score, gain);
    EXPECT_GE(score, kMinStd) << name;
    EXPECT_LE(score, kMaxStd) << name;
    EXPECT_GE(gain, kMinGain) << name;
  }
}

}  // namespace
}  // namespace alidade
