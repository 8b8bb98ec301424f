// SPDX-License-Identifier: MIT

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <Eigen/LU>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/median.h"
#include "alidade/core/parallel.h"
#include "alidade/guide/guidance.h"
#include "support/poor_set.h"

namespace alidade {
namespace {

using testing::HasSubstr;

std::vector<Observation> seenCorners(const SimulatedSet& set, const SE3& pose) {
  std::vector<Observation> corners;
  for (const Corner& corner : exactView(set.camera, set.size, set.board, pose, "").corners)
    corners.push_back({.p_board = set.board.corner(corner.id), .pixel = corner.pixel});
  return corners;
}

Eigen::MatrixXd trueInformation(const SimulatedSet& set) {
  const auto n = static_cast<Eigen::Index>(set.camera.parameters().size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
  for (const SE3& pose : set.poses) sum += viewInformation(set.camera, pose, seenCorners(set, pose));
  return sum;
}

double worstOf(const ProjectionUncertainty& uncertainty, const Eigen::MatrixXd& information,
               double sigma_px) {
  return uncertainty.worst(sigma_px * sigma_px * information.inverse()).std_px;
}

Guidance guidanceFor(const SimulatedSet& set, std::optional<double> target_px = std::nullopt) {
  const Calibration result = calibrate(set.board, set.views, {.model = std::string(set.camera.modelId())});
  return guide(result, set.views, target_px);
}

ProjectionUncertainty atInfinity(const SimulatedSet& set) {
  return {set.camera, set.size, std::numeric_limits<double>::infinity()};
}

SimulatedSet ordinarySet(int num_views, const RandomViewOptions& options = {}) {
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01});
  return simulateSet(camera, {.width = 640, .height = 480}, num_views, 0.1, 5, options);
}

TEST(NextView, ForecastsWhatTheInformationSays) {
  const SimulatedSet set = ordinarySet(8);
  const Eigen::MatrixXd information = trueInformation(set);
  const CandidateLimits limits{.nearest_m = 0.1, .farthest_m = 1};
  const NextViewSearch search({.camera = set.camera,
                               .size = set.size,
                               .information = information,
                               .directions = Eigen::MatrixXd::Identity(9, 9),
                               .variance = 0.01},
                              set.board, limits);
  EXPECT_TRUE(search.isDetermined());
  const ProjectionUncertainty uncertainty = atInfinity(set);
  EXPECT_NEAR(search.worst(), worstOf(uncertainty, information, 0.1), 1e-9);
  const auto next = search.best();
  ASSERT_TRUE(next);
  const auto candidates = viewCandidates(set.camera, set.size, set.board, limits);
  ASSERT_LT(next->candidate, candidates.size());
  const Eigen::MatrixXd more =
      viewInformation(set.camera, next->camera_from_board, candidates[next->candidate].corners);
  EXPECT_LT(next->worst_px, 0.9 * search.worst());
  EXPECT_NEAR(next->worst_px, worstOf(uncertainty, information + more, 0.1), 1e-7);
}

TEST(NextView, TakesNoBetterCandidateThanTheBest) {
  const SimulatedSet set = ordinarySet(6);
  const Eigen::MatrixXd information = trueInformation(set);
  const CandidateLimits limits{.nearest_m = 0.15, .farthest_m = 0.6};
  const NextViewSearch search({.camera = set.camera,
                               .size = set.size,
                               .information = information,
                               .directions = Eigen::MatrixXd::Identity(9, 9)},
                              set.board, limits);
  const auto next = search.best();
  ASSERT_TRUE(next);
  const ProjectionUncertainty uncertainty = atInfinity(set);
  int num_whole = 0;
  for (const ViewCandidate& candidate : viewCandidates(set.camera, set.size, set.board, limits)) {
    EXPECT_GE(candidate.corners.size(), 27u);
    const double distance = (candidate.camera_from_board * set.board.middle()).norm();
    EXPECT_TRUE(distance >= 0.15 && distance <= 0.6) << distance;
    if (!candidate.is_whole) continue;
    ++num_whole;
    const double worst =
        worstOf(uncertainty,
                information + viewInformation(set.camera, candidate.camera_from_board, candidate.corners), 1);
    EXPECT_GE(worst, next->worst_px * (1 - 1e-9));
  }
  EXPECT_GT(num_whole, 300);
}

// Views that tell focal length and distance apart badly need tilt, nothing else.
TEST(NextView, AsksForTiltWhereThereIsNone) {
  const SimulatedSet set = ordinarySet(3, {.max_tilt_deg = 0, .min_fill = 0.5, .max_fill = 0.6});
  const Guidance guidance = guidanceFor(set);
  ASSERT_TRUE(guidance.next);
  EXPECT_GT(guidance.next->sighting.tilt.total(), 0.3);
}

TEST(NextView, NamesTheWeakestDirectionWhereThereIsNoCovariance) {
  const SimulatedSet set = ordinarySet(3);
  Eigen::MatrixXd information = trueInformation(set);
  information.row(0).setZero();  // nothing about fx
  information.col(0).setZero();
  const NextViewSearch search({.camera = set.camera,
                               .size = set.size,
                               .information = information,
                               .directions = Eigen::MatrixXd::Identity(9, 9),
                               .variance = 0.01},
                              set.board, {.nearest_m = 0.1, .farthest_m = 1});
  EXPECT_FALSE(search.isDetermined());
  const auto next = search.best();
  ASSERT_TRUE(next);
  EXPECT_LT(next->worst_px, search.worst());
  Guidance guidance;
  guidance.next = next;
  EXPECT_THAT(nextViewText(guidance, set.size), HasSubstr("undetermined"));
}

TEST(NextView, GoesWhereNoCornersWere) {
  SimulatedSet set = ordinarySet(40);
  for (std::size_t i = set.poses.size(); i-- > 0;) {
    const double right =
        std::max_element(set.views[i].corners.begin(), set.views[i].corners.end(),
                         [](const Corner& a, const Corner& b) { return a.pixel.x() < b.pixel.x(); })
            ->pixel.x();
    if (right < 400) continue;
    set.poses.erase(set.poses.begin() + static_cast<std::ptrdiff_t>(i));
    set.views.erase(set.views.begin() + static_cast<std::ptrdiff_t>(i));
  }
  ASSERT_GE(set.views.size(), 4u);
  const Guidance guidance = guidanceFor(set);
  ASSERT_TRUE(guidance.next);
  double rightmost = 0;
  for (const Observation& corner : seenCorners(set, guidance.next->camera_from_board))
    rightmost = std::max(rightmost, corner.pixel.x());
  EXPECT_GT(rightmost, 560);
}

TEST(NextView, SaysWhenTheTargetIsReachedOrHowFarItIs) {
  const SimulatedSet set = ordinarySet(6);
  const Guidance now = guidanceFor(set);
  ASSERT_TRUE(now.is_determined && now.next);
  const Guidance reached = guidanceFor(set, 1.01 * now.worst_px);
  EXPECT_TRUE(reached.target->isReached());
  EXPECT_EQ(reached.target->num_more_views, 0);
  EXPECT_THAT(targetText(reached), HasSubstr(": reached"));
  const Guidance one = guidanceFor(set, 1.01 * now.next->worst_px);
  EXPECT_FALSE(one.target->isReached());
  EXPECT_EQ(one.target->num_more_views, 1);
  const Guidance more = guidanceFor(set, 0.8 * now.next->worst_px);
  ASSERT_TRUE(more.target->num_more_views);
  EXPECT_GT(*more.target->num_more_views, 1);
  const Guidance never = guidanceFor(set, 1e-6);
  EXPECT_FALSE(never.target->num_more_views);
  EXPECT_GT(never.target->forecast_px, 1e-6);
  EXPECT_THAT(targetText(never), HasSubstr("are not enough"));
}

TEST(NextView, KnowsWhatIsHeld) {
  const SimulatedSet set = ordinarySet(6);
  const auto guided = [&](const CalibratorOptions& options) {
    const Calibration result = calibrate(set.board, set.views, options);
    return guide(result, set.views);
  };
  const Guidance all = guided({.model = "radtan"});
  const Guidance some = guided({.model = "radtan", .held = {"k3", "p1", "p2"}, .same_focal = true});
  ASSERT_TRUE(all.next && some.next);
  EXPECT_LT(some.worst_px, all.worst_px);
  const std::vector<std::string> everything = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  const CalibratorOptions held{.model = "radtan",
                               .initial = InitialCamera{.camera = set.camera, .size = set.size},
                               .held = everything};
  EXPECT_FALSE(guided(held).next);
}

// The promise: by the true information of 100 sets, the view beats the median of 50 random ones.
TEST(NextView, BeatsRandomViews) {
  constexpr int kNumSets = 100;
  constexpr int kNumOthers = 50;
  std::vector<int> is_better(kNumSets, 0);
  parallelFor(kNumSets, 0, [&](std::size_t i) {
    const SimulatedSet set = drawPoorSet(i % 2 == 0 ? "radtan" : "kannala_brandt", 1000 + i);
    const Guidance guidance = guidanceFor(set);
    if (!guidance.next) return;
    const ProjectionUncertainty uncertainty = atInfinity(set);
    const Eigen::MatrixXd information = trueInformation(set);
    const auto worstWith = [&](const SE3& pose) {
      return worstOf(uncertainty, information + viewInformation(set.camera, pose, seenCorners(set, pose)),
                     kPoorSetNoisePx);
    };
    std::vector<double> others;
    for (const SE3& pose : drawOtherViews(set, kNumOthers, 5000 + i)) others.push_back(worstWith(pose));
    ASSERT_EQ(others.size(), static_cast<std::size_t>(kNumOthers));
    is_better[i] = worstWith(guidance.next->camera_from_board) < medianOf(others) ? 1 : 0;
  });
  EXPECT_GE(std::count(is_better.begin(), is_better.end(), 1), 90);
}

}  // namespace
}  // namespace alidade
