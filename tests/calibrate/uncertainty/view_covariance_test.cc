// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_evidence.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/reduced.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/adjust/noise/shape_information.h"
#include "alidade/adjust/noise/view_shares.h"
#include "alidade/core/statistics.h"
#include "support/fit_set.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr HuberLoss kLoss{.threshold_px = 0.2};

struct RobustFit {
  Fit fit;

  [[nodiscard]] std::vector<Eigen::Vector2d> errors() const {
    Fit now = fit;
    for (FitView& view : now.views) view.errors = viewErrors(now, view);
    std::vector<Eigen::Vector2d> all;
    for (const FitView& view : now.views) all.insert(all.end(), view.errors.begin(), view.errors.end());
    return all;
  }
  [[nodiscard]] double variance() const {
    return coordinateVariance(errors(), kLoss, 9 + 6 * static_cast<int>(fit.views.size()));
  }
  [[nodiscard]] std::optional<ViewCovariance> byViews(const ParamConstraint& constraint = {}) const {
    return viewCovariance(reduced(fit, LossWeights::kLeaveOut), freeDirections(9, constraint), 9, variance(),
                          meanSlope(errors(), kLoss));
  }
};

RobustFit fitViews(int num_views) {
  const std::vector<double> truth = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
  const SimulatedSet set = simulateSet(AnyCamera::make("radtan", truth), kQuadVga, num_views, 0.1, 1);
  RobustFit robust{solve(fitAt(set, "radtan", truth, kLoss))};
  EXPECT_EQ(robust.fit.summary.termination, Termination::kConverged);
  return robust;
}

// Every corner seen twice with the same error brings no news, which only the views' own pulls can tell.
TEST(ViewCovariance, IsNotFooledByRepeatedCorners) {
  RobustFit fit = fitViews(20);
  ASSERT_LT(meanSlope(fit.errors(), kLoss), 0.99);
  const auto once = fit.byViews();
  const auto plain_once = intrinsicsInformation(fit.fit).inverse;
  for (FitView& view : fit.fit.views) {
    const std::vector<Observation> copy = view.corners;
    view.corners.insert(view.corners.end(), copy.begin(), copy.end());
  }
  const auto twice = fit.byViews();
  const auto plain_twice = intrinsicsInformation(fit.fit).inverse;
  ASSERT_TRUE(once && twice && plain_once && plain_twice);
  for (int i = 0; i < 9; ++i) {
    EXPECT_NEAR(twice->covariance(i, i), once->covariance(i, i), 1e-6 * once->covariance(i, i)) << i;
    EXPECT_NEAR(twice->freedom[static_cast<std::size_t>(i)], once->freedom[static_cast<std::size_t>(i)],
                1e-6 * once->freedom[static_cast<std::size_t>(i)])
        << i;
    EXPECT_NEAR((*plain_twice)(i, i), 0.5 * (*plain_once)(i, i), 1e-6 * (*plain_once)(i, i)) << i;
  }
}

// Independent corners: both covariances estimate the same. The sums over 400 views scatter by about 7 %.
TEST(ViewCovariance, AgreesWithThePlainOneOnIndependentCorners) {
  const RobustFit fit = fitViews(400);
  const auto robust = fit.byViews();
  const auto inverse = intrinsicsInformation(fit.fit).inverse;
  ASSERT_TRUE(robust && inverse);
  for (int i = 0; i < 9; ++i) {
    EXPECT_NEAR(robust->covariance(i, i) / (fit.variance() * (*inverse)(i, i)), 1.0, 0.3) << i;
    EXPECT_GT(robust->freedom[static_cast<std::size_t>(i)], 40) << i;
    EXPECT_LT(robust->freedom[static_cast<std::size_t>(i)], 400) << i;
  }
  EXPECT_NEAR(robust->excess, 1, 0.1);
  EXPECT_LT(std::abs(robust->excess_sigmas), 4);
}

// Where only one direction is free and the views say equally much, it is the textbook: the jackknife's
// neighbour with V - 1 degrees of freedom.
TEST(ViewCovariance, IsTheVarianceOfAMeanForEqualViews) {
  const std::vector<double> samples = {1, 4, -2, 0.5, 3, -1};
  double mean = 0;
  for (const double x : samples) mean += x / 6;
  std::vector<Reduced> pulls;
  double squares = 0;
  for (const double x : samples) {
    pulls.push_back({.information = Eigen::MatrixXd::Constant(1, 1, 2.0),
                     .gradient = Eigen::VectorXd::Constant(1, 2.0 * (mean - x))});
    squares += (x - mean) * (x - mean);
  }
  const auto by_views = viewCovariance(pulls, Eigen::MatrixXd::Identity(1, 1), 1, 1.0, 1.0);
  ASSERT_TRUE(by_views);
  EXPECT_NEAR(by_views->covariance(0, 0), squares / 5 / 6, 1e-12);
  EXPECT_NEAR(by_views->freedom[0], 5, 1e-9);
  EXPECT_NEAR(by_views->effectiveStd(0) * kNormal95, 2.5706 * std::sqrt(squares / 30), 2e-3);
}

// The views of a series say the same about three directions, with errors of variance 1 that are alike in
// succession. Counts how often all is within the interval for 95 %, and how often the series is noticed.
struct SeriesCount {
  int intervals = 0;
  int covered = 0;
  int series = 0;
  int noticed = 0;
};
SeriesCount countSeries(int num_views, double alike, std::uint64_t seed) {
  constexpr int kSeries = 500;
  Random random(seed);
  SeriesCount count;
  for (int s = 0; s < kSeries; ++s) {
    Eigen::MatrixXd errors(3, num_views);
    for (int v = 0; v < num_views; ++v) {
      for (int i = 0; i < 3; ++i) {
        const double before = v == 0 ? random.normal() : errors(i, v - 1);
        errors(i, v) = v == 0 ? before : alike * before + std::sqrt(1 - alike * alike) * random.normal();
      }
    }
    const Eigen::Vector3d mean = errors.rowwise().mean();
    std::vector<Reduced> pulls;
    for (int v = 0; v < num_views; ++v)
      pulls.push_back({.information = Eigen::Matrix3d::Identity(), .gradient = mean - errors.col(v)});
    const auto by_views = viewCovariance(pulls, Eigen::Matrix3d::Identity(), 3, 1.0, 1.0);
    if (!by_views) continue;
    ++count.series;
    if (serialFactor(errors.colwise() - mean) > 1) ++count.noticed;
    for (int i = 0; i < 3; ++i) {
      ++count.intervals;
      if (std::abs(mean(i)) < kNormal95 * by_views->effectiveStd(i)) ++count.covered;
    }
  }
  return count;
}

TEST(ViewCovariance, CountsAlikeFramesOfAVideoAsFewer) {
  for (const double alike : {0.6, 0.8, 0.9}) {
    const SeriesCount video = countSeries(80, alike, 1);
    EXPECT_EQ(video.series, 500);
    EXPECT_GE(video.noticed, 490) << alike;
    EXPECT_EQ(video.intervals, 1500);
    EXPECT_GE(video.covered, 0.92 * video.intervals) << alike;  // 93 to 94 %; without the factor 67 to 32 %
  }
}

TEST(ViewCovariance, DoesNotTakeIndependentViewsForAlike) {
  for (const int num_views : {6, 12, 30, 80}) {
    const SeriesCount photos = countSeries(num_views, 0, 2);
    EXPECT_EQ(photos.series, 500);
    EXPECT_LE(photos.noticed, 5) << num_views;
    EXPECT_NEAR(photos.covered, 0.95 * photos.intervals, 0.015 * photos.intervals) << num_views;
  }
}

TEST(ViewCovariance, IsLargerThanBothInEveryDirection) {
  const RobustFit fit = fitViews(14);
  const auto by_views = fit.byViews();
  ASSERT_TRUE(by_views);
  const Eigen::MatrixXd plain = fit.variance() * *intrinsicsInformation(fit.fit).inverse;
  Random random(3);
  for (int trial = 0; trial < 100; ++trial) {
    Eigen::VectorXd direction(9);
    for (double& x : direction) x = random.normal();
    direction.array() /= plain.diagonal().array().sqrt();
    const auto along = [&](const Eigen::MatrixXd& matrix) { return direction.dot(matrix * direction); };
    EXPECT_GE(along(by_views->larger), along(plain) * (1 - 1e-9));
    EXPECT_GE(along(by_views->larger), along(by_views->covariance) * (1 - 1e-9));
  }
}

TEST(ViewCovariance, IsZeroForWhatIsHeld) {
  const auto by_views = fitViews(20).byViews({.held = {8}});
  ASSERT_TRUE(by_views);
  EXPECT_EQ(by_views->covariance(8, 8), 0);
  EXPECT_EQ(by_views->larger(8, 8), 0);
  EXPECT_EQ(by_views->effectiveStd(8), 0);
  EXPECT_GT(by_views->effectiveStd(0), 0);
}

TEST(ViewCovariance, HasTheBendAmongTheFree) {
  const RobustFit fit = fitViews(20);
  const auto pulls = reduced(fit.fit, LossWeights::kLeaveOut, bendColumns(&fit.fit.boards.front().target));
  const auto without = reduced(fit.fit, LossWeights::kLeaveOut);
  ASSERT_EQ(pulls.size(), without.size());
  for (std::size_t v = 0; v < pulls.size(); ++v) {
    ASSERT_EQ(pulls[v].gradient.size(), 11);
    EXPECT_LE((pulls[v].gradient.head(9) - without[v].gradient).norm(), 1e-6 * without[v].gradient.norm());
    EXPECT_LE((pulls[v].information.topLeftCorner(9, 9) - without[v].information).norm(),
              1e-6 * without[v].information.norm());
  }
  const auto by_views = viewCovariance(pulls, Eigen::MatrixXd::Identity(11, 11), 9, fit.variance(), 1.0);
  ASSERT_TRUE(by_views);
  EXPECT_EQ(by_views->covariance.rows(), 9);
  EXPECT_EQ(by_views->larger.rows(), 9);
}

TEST(ViewCovariance, IsNoLessThanThatByNoiseTimesTheExcessWhereViewsAreFew) {
  const RobustFit fit = fitViews(9);
  const auto by_views = fit.byViews();
  const auto inverse = intrinsicsInformation(fit.fit).inverse;
  ASSERT_TRUE(by_views && inverse);
  EXPECT_TRUE(by_views->is_pooled);
  EXPECT_NEAR(by_views->excess, 1, 0.6);
  const double times = std::max(1.0, std::pow(studentT95(8) / kNormal95, 2) * by_views->excess);
  for (int i = 0; i < 9; ++i) {
    EXPECT_GE(by_views->larger(i, i), (1 - 1e-9) * times * fit.variance() * (*inverse)(i, i)) << i;
    EXPECT_GE(by_views->larger(i, i), by_views->covariance(i, i)) << i;
    EXPECT_LE(by_views->larger(i, i), 100 * fit.variance() * (*inverse)(i, i)) << i;
    EXPECT_EQ(by_views->effectiveStd(i), std::sqrt(by_views->larger(i, i))) << i;
  }
  EXPECT_FALSE(fitViews(10).byViews()->is_pooled);
}

// A few views that know nearly everything leave the others' disagreement without a say: hardly any degrees of
// freedom, by which no finite covariance can be made from them alone.
TEST(ViewCovariance, IsFiniteWhereAFewViewsKnowNearlyEverything) {
  RobustFit fit = fitViews(12);
  for (std::size_t v = 0; v < 3; ++v) {
    for (Observation& corner : fit.fit.views[v].corners) corner.weight = 1e6;
  }
  const auto by_views = fit.byViews();
  ASSERT_TRUE(by_views);
  EXPECT_LT(*std::min_element(by_views->freedom.begin(), by_views->freedom.end()), 2);
  EXPECT_TRUE(by_views->is_pooled);
  EXPECT_TRUE(by_views->larger.view().allFinite());
  const double by_noise = fit.variance() * (*intrinsicsInformation(fit.fit).inverse)(0, 0);
  EXPECT_GE(by_views->effectiveStd(0), std::sqrt(by_noise));
}

TEST(ViewCovariance, NeedsThreeViews) {
  const RobustFit fit = fitViews(9);
  const auto pulls = reduced(fit.fit, LossWeights::kLeaveOut);
  const Eigen::MatrixXd focal = Eigen::MatrixXd::Identity(9, 1);
  const auto of = [&](std::size_t count) {
    return viewCovariance(std::span(pulls).first(count), focal, 9, fit.variance(), 1.0);
  };
  EXPECT_FALSE(of(2));
  ASSERT_TRUE(of(3));
  EXPECT_TRUE(of(3)->larger.view().allFinite());
}

}  // namespace
}  // namespace alidade
