// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/weak_prior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "alidade/adjust/board/manifolds.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/calibrator.h"
#include "support/fit_set.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr double kNoisePx = 0.1;

bool hasFinding(const Calibration& result, const char* id) {
  return std::any_of(result.diagnoses.begin(), result.diagnoses.end(),
                     [&](const Diagnosis& f) { return f.id == id; });
}

// A mild lens, seen as a quotient of polynomials: what the denominator does, the numerator does as well.
std::vector<double> mildLens(Random& random) {
  return {random.uniform(900, 1300),
          random.uniform(900, 1300),
          640 + random.uniform(-20, 20),
          480 + random.uniform(-20, 20),
          random.uniform(-0.15, 0.1),
          random.uniform(-0.05, 0.05),
          random.uniform(-1e-3, 1e-3),
          random.uniform(-1e-3, 1e-3),
          0,
          0,
          0,
          0};
}

// The largest error of the projection of rays all over the image, in stated sigmas an axis; how many it
// compared.
int largestError(const Calibration& result, const AnyCamera& truth, double& largest) {
  const auto n = static_cast<Eigen::Index>(truth.parameters().size());
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J(2, n);
  int count = 0;
  largest = 0;
  for (int x = 0; x <= 8; ++x) {
    for (int y = 0; y <= 6; ++y) {
      const Eigen::Vector2d pixel(x / 8.0 * (kQuadVga.width - 1), y / 6.0 * (kQuadVga.height - 1));
      const auto ray = truth.unproject(pixel);
      if (!ray) continue;
      const Projection found = result.camera().project(*ray, nullptr, J.data());
      if (!found.ok()) continue;
      const Eigen::Matrix2d covariance = J * result.uncertainty.covariance->view() * J.transpose();
      const Eigen::Vector2d error = found.pixel - pixel;
      largest =
          std::max(largest, error.cwiseQuotient(covariance.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff());
      ++count;
    }
  }
  return count;
}

TEST(WeakPrior, KeepsARationalLensWithinReason) {
  constexpr int kNumSets = 20;
  int num_held = 0;
  for (const int num_views : {12, 30}) {
    int num_near = 0;
    double worst = 0;
    for (std::uint64_t seed = 1; seed <= kNumSets; ++seed) {
      SCOPED_TRACE(testing::Message() << num_views << " views, seed " << seed);
      Random random(streamSeed(77, seed));
      std::vector<double> params = mildLens(random);
      params[1] = params[0] * random.uniform(0.995, 1.005);
      const AnyCamera truth = AnyCamera::make("rational", params);
      const SimulatedSet set = simulateSet(truth, kQuadVga, num_views, kNoisePx, seed);
      const Calibration result = calibrate(set.board, set.views, {.model = "rational"});
      EXPECT_TRUE(result.isUsable());
      ASSERT_TRUE(result.uncertainty.covariance);
      const LensScale scale = lensScale("rational", result.camera(), kQuadVga);
      for (std::size_t i = 4; i < params.size(); ++i) {
        EXPECT_LT(scale.distance(onlyCamera(result.fit).params, i), 1.01)
            << result.camera().parameterNames()[i];
        EXPECT_LT(std::abs(onlyCamera(result.fit).params[i]), 20) << result.camera().parameterNames()[i];
      }
      const bool is_held = !onlyCamera(result.fit).weak_prior.isNone();
      EXPECT_EQ(hasFinding(result, "ill_conditioned"), is_held);
      EXPECT_EQ(onlyCamera(result.fit).weak_prior.least_known.empty(), !is_held);
      num_held += is_held ? 1 : 0;
      double largest = 0;
      EXPECT_EQ(largestError(result, truth, largest), 63);
      if (largest < 3) ++num_near;
      worst = std::max(worst, largest);
    }
    std::printf("%d views: %d of %d sets within 3 stated sigmas, the worst %.2f\n", num_views, num_near,
                kNumSets, worst);
    EXPECT_GE(num_near, 18);
  }
  std::printf("%d of %d sets held\n", num_held, 2 * kNumSets);
  EXPECT_GE(num_held, 10) << "or these lenses are not mild";
}

TEST(WeakPrior, LeavesAloneWhatIsDetermined) {
  const std::vector<double> params = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
  const AnyCamera truth = AnyCamera::make("radtan", params);
  int num_sets = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedSet set = simulateSet(truth, kQuadVga, 20, kNoisePx, seed);
    const Fit before = settledFromStart(fitAt(set, truth), nullptr).fit;
    ASSERT_EQ(before.summary.termination, Termination::kConverged);
    const Fit after = regularised(before, nullptr);
    EXPECT_TRUE(after.cameras.front().weak_prior.isNone());
    EXPECT_EQ(after.cameras.front().params, before.cameras.front().params) << "to the last bit";
    for (std::size_t v = 0; v < before.views.size(); ++v) {
      EXPECT_EQ(toBlock(cameraFromBoard(after, after.views[v])),
                toBlock(cameraFromBoard(before, before.views[v])));
    }
    ++num_sets;
  }
  EXPECT_EQ(num_sets, 10);
}

// Few views leave the image's corners empty, where noise in k3 may fold the lens.
TEST(WeakPrior, FewViewsDoNotFoldARadtanLens) {
  const std::vector<double> params = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
  const AnyCamera truth = AnyCamera::make("radtan", params);
  int num_held = 0;
  int num_sets = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const SimulatedSet set = simulateSet(truth, kQuadVga, 12, kNoisePx, seed);
    const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
    EXPECT_TRUE(result.domain.full_image) << "seed " << seed;
    const bool is_held = !onlyCamera(result.fit).weak_prior.isNone();
    EXPECT_EQ(hasFinding(result, "ill_conditioned"), is_held);
    if (is_held) {
      double largest = 0;
      ASSERT_TRUE(result.uncertainty.covariance);
      EXPECT_EQ(largestError(result, truth, largest), 63);
      std::printf("seed %d: prior of %g, error %.2f stated sigmas at most\n", static_cast<int>(seed),
                  onlyCamera(result.fit).weak_prior.width, largest);
      EXPECT_LT(largest, 3);
    }
    num_held += is_held ? 1 : 0;
    ++num_sets;
  }
  EXPECT_EQ(num_sets, 40);
  EXPECT_GE(num_held, 1) << "nothing to be seen here otherwise";
  EXPECT_LE(num_held, 6);
}

// Boards that keep to the middle leave k3 to noise, which may fold the lens in the corners.
TEST(WeakPrior, UnfoldsALensInCornersThatNoBoardReached) {
  const std::vector<double> params = {900, 900, 640, 480, -0.28, 0.09, 5e-4, -4e-4, -0.012};
  const AnyCamera truth = AnyCamera::make("radtan", params);
  int num_held = 0;
  int num_sets = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SimulatedSet set = simulateSet(truth, kQuadVga, 12, 0.3, seed);
    for (View& view : set.views) {
      std::erase_if(view.corners,
                    [](const Corner& c) { return (c.pixel - Eigen::Vector2d(640, 480)).norm() > 400; });
    }
    std::erase_if(set.views, [](const View& view) { return view.corners.size() < 18; });
    if (set.views.size() < 8) continue;
    const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
    EXPECT_TRUE(result.domain.full_image || hasFinding(result, "folds_in_image"));
    if (!onlyCamera(result.fit).weak_prior.isNone()) {
      EXPECT_TRUE(result.domain.full_image);
      EXPECT_TRUE(hasFinding(result, "ill_conditioned"));
      for (std::size_t i = 4; i < params.size(); ++i) {
        EXPECT_LT(std::abs(onlyCamera(result.fit).params[i] - params[i]),
                  5 * result.uncertainty.parameterStdByNoise(static_cast<int>(i)))
            << seed << " " << result.camera().parameterNames()[i];
      }
      ++num_held;
    }
    ++num_sets;
  }
  std::printf("%d of %d sets would fold\n", num_held, num_sets);
  EXPECT_GE(num_sets, 20);
  EXPECT_GE(num_held, 1) << "nothing to be seen here otherwise";
}

// Truths about the model's start, views that say something or nothing of them, and estimates under a prior.
TEST(WeakPrior, NarrowPriorsDoNotMakeSigmasSmall) {
  const LensScale scale{.mean = {0, 0, 0, 0, 0}, .size = {0, 0, 0, 0, 2}};
  constexpr double kVariance = 0.04;
  constexpr int kNumDraws = 2000;
  Random random(8);
  int num_cases = 0;
  for (const double known : {0.0, 0.01, 1.0}) {
    Eigen::MatrixXd information = Eigen::MatrixXd::Identity(5, 5);
    information(4, 4) = known;
    for (const double width : {10.0, 1.0, 0.1, 0.03}) {
      const WeakPrior held{.width = width, .prior = scale.prior(width, kVariance), .scale = scale};
      double sum_z2 = 0;
      double least = std::numeric_limits<double>::infinity();
      for (int i = 0; i < kNumDraws; ++i) {
        const double truth = 2 * std::max(width, 1.0) * random.normal();
        const double by_views = known * truth + std::sqrt(known * kVariance) * random.normal();
        const double estimate = by_views / (known + held.prior.precision[4]);
        FitCamera camera;
        camera.params = {0, 0, 0, 0, estimate};
        camera.weak_prior = held;
        const auto covariance = heldCovariance(information, camera, kVariance);
        ASSERT_TRUE(covariance);
        const double variance = (*covariance)(4, 4);
        EXPECT_NEAR((*covariance)(0, 0), kVariance, 1e-12);
        sum_z2 += (estimate - truth) * (estimate - truth) / variance;
        least = std::min(least, variance);
      }
      // What the views do not tell at all is known to a natural size and no better.
      if (known == 0) {
        EXPECT_NEAR(least, std::pow(2 * std::max(width, 1.0), 2), 1e-9);
      }
      EXPECT_NEAR(sum_z2 / kNumDraws, 1, 0.15) << known << " " << width;
      ++num_cases;
    }
  }
  EXPECT_EQ(num_cases, 12);
}

}  // namespace
}  // namespace alidade
