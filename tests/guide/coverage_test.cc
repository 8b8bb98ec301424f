// SPDX-License-Identifier: MIT
#include "alidade/guide/coverage.h"

#include <numeric>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/degrees.h"
#include "alidade/simulate/observe.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr Checkerboard kCoveredBoard{.columns = 9, .rows = 6, .square_m = 0.02};

// A calibration as coverageOf() reads it: views at pixels, tilts in degrees.
struct Placement {
  double u, v, distance_m, right_deg, lower_deg;
};

struct Set {
  Calibration result{.fit = emptyFit("pinhole", kVga, {500, 500, 319.5, 239.5}, kCoveredBoard, kNoLoss)};
  std::vector<View> views;
};

Set makeSet(const std::vector<Placement>& placements) {
  Set set;
  for (const Placement& at : placements) {
    const SO3 rotation =
        tiltedBoard({.right_rad = kRadPerDeg * at.right_deg, .lower_rad = kRadPerDeg * at.lower_deg});
    const SE3 pose{rotation, at.distance_m * *set.result.camera().unproject({at.u, at.v}) -
                                 rotation * kCoveredBoard.middle()};
    const std::string name = "view_" + std::to_string(set.views.size());
    set.views.push_back(exactView(set.result.camera(), kVga, kCoveredBoard, pose, name));
    addView(set.result.fit, set.views.size() - 1, observationsOf(kCoveredBoard, set.views.back()), pose);
    set.result.fit.views.back().image = name;
  }
  return set;
}

TEST(Coverage, CountsTheCornersOfEachCell) {
  const Set set = makeSet({{150, 120, 0.4, 0, 0}, {150, 350, 0.4, 0, 0}, {200, 240, 0.6, 0, 0}});
  const CoverageReport report = coverageOf(set.result, set.views);
  EXPECT_EQ(report.columns, 8);
  EXPECT_EQ(report.rows, 6);
  ASSERT_EQ(report.num_corners.size(), 48u);
  EXPECT_EQ(std::accumulate(report.num_corners.begin(), report.num_corners.end(), 0), 3 * 54);
  int num_right = 0;
  for (int row = 0; row < 6; ++row) num_right += report.num_corners[static_cast<std::size_t>(8 * row + 7)];
  EXPECT_EQ(num_right, 0);
  EXPECT_LT(report.share, 0.6);
  EXPECT_THAT(report.empty_regions,
              ElementsAre(ImageRegion{.column = 2, .row = 0}, ImageRegion{.column = 2, .row = 1},
                          ImageRegion{.column = 2, .row = 2}));
  EXPECT_THAT(coverageText(report), HasSubstr("almost no board corners in the upper right corner, the right "
                                              "border and the lower right corner of the image"));
}

TEST(Coverage, LeavesOutliersAndUnusedViewsOut) {
  Set set = makeSet({{150, 120, 0.4, 0, 0}, {150, 350, 0.4, 0, 0}, {500, 240, 0.6, 0, 0}});
  set.result.fit.views.pop_back();
  std::vector<Observation>& used = set.result.fit.views.front().corners;
  used.erase(used.begin(), used.begin() + 10);
  const CoverageReport report = coverageOf(set.result, set.views);
  EXPECT_EQ(std::accumulate(report.num_corners.begin(), report.num_corners.end(), 0), 2 * 54 - 10);
  EXPECT_EQ(report.views.size(), 2u);
}

TEST(Coverage, MeasuresTiltsAndDistances) {
  const Set set = makeSet({{320, 240, 0.5, 20, 0},
                           {320, 240, 0.4, -35, 0},
                           {320, 240, 0.8, 0, 40},
                           {320, 240, 0.6, 0, 0},
                           {320, 240, 0.6, 10, -5}});
  const CoverageReport report = coverageOf(set.result, set.views);
  EXPECT_EQ(report.numTilted(kTiltedRad), 3);
  EXPECT_EQ(report.numTilted(kSteepRad), 2);
  EXPECT_THAT(report.num_tilted_to, ElementsAre(1, 1, 0, 1));  // left, right, upper, lower
  EXPECT_NEAR(report.nearest_m, 0.4, 1e-12);
  EXPECT_NEAR(report.farthest_m, 0.8, 1e-12);
  // 8 squares of 20 mm, 0.6 m away: 133 of 640 px; 0.8 m away and 5 squares leant by 40 degrees: less.
  EXPECT_NEAR(report.views[3].fill, 8 * 0.02 / 0.6 * 500 / 640, 1e-6);
  for (const ViewCoverage& view : report.views) EXPECT_GE(view.fill, report.views[2].fill);
  EXPECT_THAT(
      coverageText(report),
      HasSubstr(
          "sides of the board that no view has turned towards the camera by more than 15 degrees: upper\n"));
}

TEST(Coverage, SaysOneLineWhereNothingIsMissing) {
  std::vector<Placement> placements;
  for (const double u : {100.0, 320.0, 540.0}) {
    for (const double v : {80.0, 240.0, 400.0}) {
      placements.push_back({u, v, 0.42, 20, 0});
      placements.push_back({u, v, 0.42, -20, 0});
      placements.push_back({u, v, 0.42, 0, 20});
      placements.push_back({u, v, 0.42, 0, -20});
    }
  }
  const Set set = makeSet(placements);
  const CoverageReport report = coverageOf(set.result, set.views);
  EXPECT_THAT(report.empty_regions, ElementsAre());
  EXPECT_GT(report.border_share, 0.9);
  EXPECT_EQ(report.num_image_corners, 4);
  const std::string text = coverageText(report);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
}

}  // namespace
}  // namespace alidade
