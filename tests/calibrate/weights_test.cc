// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/core/error.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
const std::vector<double> kWeightedTruth = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};

void stateSigmas(SimulatedSet& set, const std::function<double(const Corner&)>& sigma) {
  for (View& view : set.views) {
    for (Corner& corner : view.corners) corner.sigma_px = sigma(corner);
  }
}

// Each corner has noise of one of two sizes, which it states.
SimulatedSet mixedSet(double small_px, double large_px, std::uint64_t seed, double tau_px = 0,
                      const char* model = "radtan", const std::vector<double>& truth = kWeightedTruth) {
  SimulatedSet set = simulateSet(AnyCamera::make(model, truth), kQuadVga, 12, 0.0, seed);
  Random random(streamSeed(seed, 1));
  for (View& view : set.views) {
    for (Corner& corner : view.corners) {
      corner.sigma_px = random.uniform() < 0.5 ? small_px : large_px;
      const double sigma = std::hypot(corner.sigma_px, tau_px);
      corner.pixel.x() += sigma * random.normal();
      corner.pixel.y() += sigma * random.normal();
    }
  }
  return set;
}

void expectSame(const Calibration& a, const Calibration& b) {
  ASSERT_TRUE(a.uncertainty.covariance && b.uncertainty.covariance);
  for (std::size_t i = 0; i < kWeightedTruth.size(); ++i) {
    EXPECT_EQ(onlyCamera(a.fit).params[i], onlyCamera(b.fit).params[i]) << a.camera().parameterNames()[i];
  }
  EXPECT_EQ(*a.uncertainty.covariance, *b.uncertainty.covariance);
  EXPECT_EQ(rms(a.fit), rms(b.fit));
  EXPECT_EQ(weightedRms(a.fit), weightedRms(b.fit));
  EXPECT_EQ(a.uncertainty.coordinate_sigma_px, b.uncertainty.coordinate_sigma_px);
  EXPECT_EQ(a.uncertainty.local_sigma_px, b.uncertainty.local_sigma_px);
  EXPECT_EQ(a.dropped.outliers.size(), b.dropped.outliers.size());
}

TEST(Weights, EqualOrUnknownSigmasChangeNothing) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimulatedSet set = simulateSet(AnyCamera::make("radtan", kWeightedTruth), kQuadVga, 10, 0.1, seed);
    set.views[2].corners[7].pixel.x() += 9;
    stateSigmas(set, [](const Corner&) { return kUnknown; });
    const Calibration unknown = calibrate(set.board, set.views, {.model = "radtan"});
    EXPECT_TRUE(std::isnan(unknown.uncertainty.unexplained_sigma_px));
    EXPECT_EQ(weightedRms(unknown.fit), rms(unknown.fit));
    EXPECT_EQ(unknown.dropped.outliers.size(), 1U);
    // True, three times too wide and three times too narrow: the scale comes from the residuals.
    for (const double stated : {0.1, 0.3, 0.1 / 3}) {
      stateSigmas(set, [&](const Corner&) { return stated; });
      const Calibration equal = calibrate(set.board, set.views, {.model = "radtan"});
      expectSame(equal, unknown);
      const double left = std::pow(equal.uncertainty.coordinate_sigma_px, 2) - stated * stated;
      EXPECT_NEAR(equal.uncertainty.unexplained_sigma_px, std::sqrt(std::max(0.0, left)), 1e-12);
    }
    stateSigmas(set, [&](const Corner& corner) { return corner.id % 3 == 0 ? kUnknown : 0.02; });
    expectSame(calibrate(set.board, set.views, {.model = "radtan"}), unknown);
  }
}

// Doubling all sigmas scales all variances exactly, so that not even rounding differs.
TEST(Weights, OnlyRatiosMatterWhereSigmasAreTooWide) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimulatedSet set = mixedSet(0.02, 0.2, seed);
    stateSigmas(set, [&](const Corner& corner) { return 3 * corner.sigma_px; });
    const Calibration wide = calibrate(set.board, set.views, {.model = "radtan"});
    EXPECT_EQ(wide.uncertainty.unexplained_sigma_px, 0);
    EXPECT_NEAR(wide.uncertainty.coordinate_sigma_px, 0.0281, 0.003);
    stateSigmas(set, [&](const Corner& corner) { return 2 * corner.sigma_px; });
    expectSame(calibrate(set.board, set.views, {.model = "radtan"}), wide);
  }
}

// What detection does not know is found, and makes corners count nearly alike.
TEST(Weights, AnUnmodelledErrorIsFoundAndEvensThemOut) {
  int num_compared = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SimulatedSet set = mixedSet(0.01, 0.05, seed, 0.1);
    const Calibration weighted = calibrate(set.board, set.views, {.model = "radtan"});
    EXPECT_NEAR(weighted.uncertainty.unexplained_sigma_px, 0.1, 0.01);
    EXPECT_NEAR(weighted.uncertainty.coordinate_sigma_px, 0.106, 0.01);
    stateSigmas(set, [](const Corner&) { return kUnknown; });
    const Calibration plain = calibrate(set.board, set.views, {.model = "radtan"});
    // A lens that would fold is held by a prior, which may be another one.
    if (!onlyCamera(weighted.fit).weak_prior.isNone() || !onlyCamera(plain.fit).weak_prior.isNone()) continue;
    ++num_compared;
    for (int i = 0; i < 9; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double std = plain.uncertainty.parameterStdByNoise(i);
      EXPECT_NEAR(onlyCamera(weighted.fit).params[k], onlyCamera(plain.fit).params[k], 0.5 * std);
      EXPECT_NEAR(weighted.uncertainty.parameterStdByNoise(i), std, 0.1 * std);
    }
  }
  EXPECT_GE(num_compared, 8);
}

TEST(Weights, TrueSigmasLeaveNothingUnexplained) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedSet set = mixedSet(0.02, 0.2, seed);
    const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
    EXPECT_LT(result.uncertainty.unexplained_sigma_px, 0.01);
    // Half of the corners carry nearly all that is known: 1 / mean(1 / sigma^2).
    EXPECT_NEAR(result.uncertainty.coordinate_sigma_px, 0.0281, 0.003);
    EXPECT_NEAR(result.uncertainty.local_sigma_px, result.uncertainty.coordinate_sigma_px,
                0.15 * result.uncertainty.coordinate_sigma_px);
    EXPECT_GT(rms(result.fit), 0.17);
    EXPECT_TRUE(result.dropped.outliers.empty());
    for (const Diagnosis& diagnosis : result.diagnoses)
      EXPECT_EQ(diagnosis.id, "poor_coverage") << diagnosis.message();
  }
}

// Poor corners that say so are neither outliers nor a misfit; gross ones are outliers whatever they say.
TEST(Weights, AnOutlierIsJudgedByWhatItStates) {
  SimulatedSet set = simulateSet(AnyCamera::make("radtan", kWeightedTruth), kQuadVga, 15, 0.02, 3);
  const auto spoil = [&](std::size_t view, std::size_t corner, double off, double stated) {
    set.views[view].corners[corner].pixel += Eigen::Vector2d(off, -off / 2);
    set.views[view].corners[corner].sigma_px = stated;
    return set.views[view].corners[corner].id;
  };
  spoil(2, 5, 1.0, 0.3);
  spoil(3, 11, -0.8, 0.3);
  const int off_by_much = spoil(4, 20, 10.0, 0.3);
  const int off_unawares = spoil(6, 8, 1.0, 0.02);
  const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
  std::vector<std::pair<std::string, int>> named;
  for (const Outlier& outlier : result.dropped.outliers) named.emplace_back(outlier.image, outlier.corner_id);
  EXPECT_THAT(named, testing::UnorderedElementsAre(std::pair(set.views[4].image, off_by_much),
                                                   std::pair(set.views[6].image, off_unawares)));
  for (std::size_t i = 0; i < kWeightedTruth.size(); ++i) {
    EXPECT_NEAR(onlyCamera(result.fit).params[i], kWeightedTruth[i],
                4 * result.uncertainty.parameterStdByNoise(static_cast<int>(i)));
  }
}

TEST(Weights, ManyPoorCornersAreNoMisfit) {
  const SimulatedSet set = mixedSet(0.05, 3.0, 1);
  const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
  EXPECT_GT(rms(result.fit), 0.0005 * std::hypot(kQuadVga.width, kQuadVga.height));
  for (const Diagnosis& diagnosis : result.diagnoses)
    EXPECT_EQ(diagnosis.id, "poor_coverage") << diagnosis.message();
}

TEST(Weights, AModelIsFoundTooLeanThroughPoorCorners) {
  int num_lean = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto is_too_lean = [](const SimulatedSet& set) {
      return calibrate(set.board, set.views, {.model = "pinhole"}).choice.better_model.has_value();
    };
    // A distortion of 1.5 px in the image's corners, most of which another focal length takes up, among
    // corners of which half have noise of that size.
    const std::vector<double> mild = {1003, 1001, 645, 475, -0.003, 0, 0, 0, 0};
    if (is_too_lean(mixedSet(0.02, 1.0, seed, 0, "radtan", mild))) ++num_lean;
    EXPECT_FALSE(is_too_lean(mixedSet(0.02, 1.0, seed, 0, "pinhole", {1003, 1001, 645, 475})));
  }
  EXPECT_EQ(num_lean, 10);
}

TEST(Weights, DoNotDependOnTheOrderOfViews) {
  SimulatedSet set = mixedSet(0.02, 0.2, 1);
  const Calibration first = calibrate(set.board, set.views, {.model = "radtan"});
  std::reverse(set.views.begin(), set.views.end());
  const Calibration second = calibrate(set.board, set.views, {.model = "radtan"});
  expectSame(second, first);
  EXPECT_EQ(second.uncertainty.unexplained_sigma_px, first.uncertainty.unexplained_sigma_px);
}

TEST(Weights, ANegativeSigmaIsRefused) {
  SimulatedSet set = mixedSet(0.02, 0.2, 1);
  set.views[3].corners[5].sigma_px = -0.1;
  EXPECT_THROW(static_cast<void>(calibrate(set.board, set.views, {.model = "radtan"})), Error);
}

}  // namespace
}  // namespace alidade
