// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/model_spread.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/uncertainty/far_difference.h"
#include "support/choice_sweep.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{.width = 1280, .height = 960};

AnyCamera lens(double k1) {
  return AnyCamera::make("kannala_brandt", std::vector<double>{611, 612, 634, 491, k1, 0, 0, 0});
}

std::vector<Eigen::Vector2d> pixelsWithin(double radius_px, double step_px) {
  std::vector<Eigen::Vector2d> pixels;
  for (double x = 0; x < kSize.width; x += step_px) {
    for (double y = 0; y < kSize.height; y += step_px) {
      if (std::hypot(x - 634, y - 491) < radius_px) pixels.emplace_back(x, y);
    }
  }
  return pixels;
}

UncertaintyGrid gridWith(double std_px) {
  UncertaintyGrid grid;
  grid.pixels = pixelsWithin(2000, 40);
  grid.std_px.assign(grid.pixels.size(), std_px);
  return grid;
}

TEST(FarDifferences, AreNoneBetweenACameraAndItself) {
  const std::vector<Eigen::Vector2d> pixels = pixelsWithin(2000, 40);
  const auto differences = farDifferences(lens(-0.02), lens(-0.02), pixels, pixelsWithin(300, 40));
  ASSERT_EQ(differences.size(), pixels.size());
  EXPECT_LT(*std::max_element(differences.begin(), differences.end()), 1e-9);
}

// cx and cy are moved: a turn of the camera, nearly, and only where the anchors are it is exactly that.
TEST(FarDifferences, LeaveOutTheRotationThatFitsAtTheAnchors) {
  const AnyCamera a = AnyCamera::make("pinhole", std::vector<double>{1000, 1000, 640, 480});
  const AnyCamera b = AnyCamera::make("pinhole", std::vector<double>{1000, 1000, 650, 480});
  std::vector<Eigen::Vector2d> anchors;
  for (double x = 600; x <= 690; x += 10) anchors.emplace_back(x, 480);
  const std::vector<Eigen::Vector2d> pixels = {{645, 480}, {0, 0}, {1279, 959}};
  const auto differences = farDifferences(a, b, pixels, anchors);
  EXPECT_LT(differences[0], 0.02);
  // A turn by 0.01 rad moves a pixel x from the centre by 10 (1 + x^2 / f^2) px, and the shift by 10.
  EXPECT_NEAR(differences[1], std::hypot(10 * 0.645 * 0.645, 10 * 0.645 * 0.48), 0.4);
  EXPECT_NEAR(differences[2], std::hypot(10 * 0.634 * 0.634, 10 * 0.634 * 0.48), 0.4);
}

TEST(ModelSpread, IsOfTheRivalThatDiffersOverTheLargestPart) {
  const std::vector<Eigen::Vector2d> corners = pixelsWithin(250, 25);
  const std::vector<RivalCamera> rivals = {
      {.id = "kannala_brandt", .params = {611, 612, 634, 491, -0.021, 0, 0, 0}},
      {.id = "kannala_brandt", .params = {611, 612, 634, 491, -0.03, 0, 0, 0}}};
  const auto spread = modelSpread(lens(-0.02), rivals, corners, gridWith(0.1));
  ASSERT_TRUE(spread);
  // 0.01 f theta^3 with theta = r / f to first order: 1 px at theta = 0.547 rad, r = 334 px.
  const std::vector<Eigen::Vector2d> all = gridWith(0).pixels;
  const auto beyond = std::count_if(all.begin(), all.end(), [](const Eigen::Vector2d& pixel) {
    return (pixel - Eigen::Vector2d(634, 491)).norm() > 334;
  });
  EXPECT_NEAR(spread->share_apart, static_cast<double>(beyond) / static_cast<double>(all.size()), 0.02);
  EXPECT_EQ(spread->worst_pixel, Eigen::Vector2d(0, 0));
  EXPECT_GT(spread->worst_px, 5);

  EXPECT_EQ(modelSpread(lens(-0.02), rivals, corners, gridWith(100))->share_apart, 0) << "within 3 sigmas";
  EXPECT_FALSE(modelSpread(lens(-0.02), {}, corners, gridWith(0.1)));
}

// Boards stay in the middle of a fisheye's image: several formulas fit, and no corner says which is right
// beyond.
TEST(ModelSpread, IsToldWhereTheChoiceDecidesWhatTheImageShows) {
  const std::vector<double> truth = {611, 611.6, 634.6, 491.6, -0.03, 0.004, -0.002, 0};
  const AnyCamera camera = AnyCamera::make("kannala_brandt", truth);
  int num_sets = 0;
  int num_astray = 0;
  for (const int num_views : {5, 12}) {
    for (std::uint64_t seed = 0; seed < 4; ++seed, ++num_sets) {
      const SimulatedSet set = simulateSet(
          camera, kSize, num_views, 0.1, seed,
          {.max_tilt_deg = 40, .max_roll_deg = 30, .min_fill = 0.2, .max_fill = 0.4, .margin_px = 150});
      const Calibration result = calibrate(set.board, set.views, {.model = "auto"});
      std::vector<Eigen::Vector2d> corners;
      for (const View& view : set.views) {
        for (const Corner& corner : view.corners) corners.push_back(corner.pixel);
      }
      ASSERT_TRUE(result.uncertainty.projection_far);
      const RivalCamera rival{.id = "kannala_brandt", .params = truth};
      const auto astray =
          modelSpread(result.camera(), std::span(&rival, 1), corners, *result.uncertainty.projection_far);
      ASSERT_TRUE(astray);
      const bool is_told = hasFinding(result, "poor_coverage") || hasFinding(result, "inaccurate");
      if (astray->share_apart <= 0.1) continue;
      ++num_astray;
      EXPECT_TRUE(is_told) << num_views << " views, seed " << seed;
      EXPECT_NE(result.verdict(), Verdict::kTrustworthy) << num_views << " views, seed " << seed;
    }
  }
  EXPECT_EQ(num_sets, 8);
  EXPECT_GE(num_astray, 4);
}

TEST(ModelSpread, IsNotToldWhereBoardsWereAllOverTheImage) {
  int num_sets = 0;
  int num_compared = 0;
  for (const char* model : {"radtan", "kannala_brandt", "double_sphere"}) {
    for (std::uint64_t number = 0; number < 3; ++number, ++num_sets) {
      const ChoiceSet set = drawChoiceSet(model, 7, number);
      const Calibration result = calibrate(set.set.board, set.set.views, {.model = "auto"});
      EXPECT_LT(shareAstray(set, result), 0.1) << model << " " << number;
      num_compared += result.uncertainty.model_spread ? 1 : 0;
    }
  }
  EXPECT_EQ(num_sets, 9);
  EXPECT_GE(num_compared, 4);
}

}  // namespace
}  // namespace alidade
