// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/aligned_difference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/projection_uncertainty.h"
#include "support/choice_sweep.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

AnyCamera lens(double k1) {
  return AnyCamera::make("kannala_brandt", std::vector<double>{611, 612, 634, 491, k1, 0, 0, 0});
}

std::vector<Eigen::Vector2d> pixelsWithin(double radius_px, double step_px) {
  std::vector<Eigen::Vector2d> pixels;
  for (double x = 0; x < kQuadVga.width; x += step_px) {
    for (double y = 0; y < kQuadVga.height; y += step_px) {
      if (std::hypot(x - 634, y - 491) < radius_px) pixels.emplace_back(x, y);
    }
  }
  return pixels;
}

TEST(AlignedDifferences, AreNoneBetweenACameraAndItself) {
  const std::vector<Eigen::Vector2d> pixels = pixelsWithin(2000, 40);
  const auto differences = alignedDifferences(lens(-0.02), lens(-0.02), pixels, pixelsWithin(300, 40));
  ASSERT_EQ(differences.size(), pixels.size());
  EXPECT_LT(*std::max_element(differences.begin(), differences.end()), 1e-9);
}

// cx and cy are moved: a turn of the camera, nearly, and only where the anchors are it is exactly that.
TEST(AlignedDifferences, LeaveOutTheRotationThatFitsAtTheAnchors) {
  const AnyCamera a = AnyCamera::make("pinhole", std::vector<double>{1000, 1000, 640, 480});
  const AnyCamera b = AnyCamera::make("pinhole", std::vector<double>{1000, 1000, 650, 480});
  std::vector<Eigen::Vector2d> anchors;
  for (double x = 600; x <= 690; x += 10) anchors.emplace_back(x, 480);
  const std::vector<Eigen::Vector2d> pixels = {{645, 480}, {0, 0}, {1279, 959}};
  const auto differences = alignedDifferences(a, b, pixels, anchors);
  EXPECT_LT(differences[0], 0.02);
  // A turn by 0.01 rad moves a pixel x from the centre by 10 (1 + x^2 / f^2) px, and the shift by 10.
  EXPECT_NEAR(differences[1], std::hypot(10 * 0.645 * 0.645, 10 * 0.645 * 0.48), 0.4);
  EXPECT_NEAR(differences[2], std::hypot(10 * 0.634 * 0.634, 10 * 0.634 * 0.48), 0.4);
}

// At a finite distance a pose follows: against the linear prediction for a small change of the focal length.
TEST(AlignedDifferences, LeaveOutThePoseAtAFiniteDistance) {
  const AnyCamera a =
      AnyCamera::make("kannala_brandt", std::vector<double>{1000, 1000, 634, 491, 0, 0, 0, 0});
  const AnyCamera b =
      AnyCamera::make("kannala_brandt", std::vector<double>{1001, 1000, 634, 491, 0, 0, 0, 0});
  const std::vector<Eigen::Vector2d> pixels = pixelsWithin(450, 30);
  const AlignedJacobians aligned = alignedJacobians(a, pixels, {}, Freed::kPose);
  const auto differences = alignedDifferences(a, b, pixels, pixels, 2.0);
  const auto far = alignedDifferences(a, b, pixels, pixels);
  double expected = 0;
  double found = 0;
  double found_far = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    expected += aligned.transposed.view().row(0).segment<2>(2 * static_cast<Eigen::Index>(i)).squaredNorm();
    found += differences[i] * differences[i];
    found_far += far[i] * far[i];
  }
  EXPECT_GE(pixels.size(), 600u);
  EXPECT_NEAR(std::sqrt(found / expected), 1, 0.1);
  EXPECT_LT(found, 0.9 * found_far) << "a pose takes up more than a rotation";
  EXPECT_EQ(alignedDifferences(a, b, pixels, pixels, 0.5), differences) << "the same at all distances";
}

// Boards stay in the middle of a fisheye's image: several formulas fit, and no corner says which is right
// beyond.
TEST(ModelChoice, IsToldWhereItDecidesWhatTheImageShows) {
  const std::vector<double> truth = {611, 611.6, 634.6, 491.6, -0.03, 0.004, -0.002, 0};
  const AnyCamera camera = AnyCamera::make("kannala_brandt", truth);
  int num_sets = 0;
  int num_astray = 0;
  for (const int num_views : {5, 12}) {
    for (std::uint64_t seed = 0; seed < 4; ++seed, ++num_sets) {
      const SimulatedSet set = simulateSet(
          camera, kQuadVga, num_views, 0.1, seed,
          {.max_tilt_deg = 40, .max_roll_deg = 30, .min_fill = 0.2, .max_fill = 0.4, .margin_px = 150});
      const Calibration result = calibrate(set.board, set.views, {.model = "auto"});
      ASSERT_TRUE(result.uncertainty.projection_far);
      const bool is_told = hasFinding(result, "poor_coverage") || hasFinding(result, "inaccurate");
      if (shareAstray(camera, set.views, result) <= 0.1) continue;
      ++num_astray;
      EXPECT_TRUE(is_told) << num_views << " views, seed " << seed;
      EXPECT_NE(result.verdict(), Verdict::kTrustworthy) << num_views << " views, seed " << seed;
    }
  }
  EXPECT_EQ(num_sets, 8);
  EXPECT_GE(num_astray, 4);
}

TEST(ModelChoice, DecidesLittleWhereBoardsWereAllOverTheImage) {
  int num_sets = 0;
  for (const char* model : {"radtan", "kannala_brandt", "double_sphere"}) {
    for (std::uint64_t number = 0; number < 3; ++number, ++num_sets) {
      const ChoiceSet set = drawChoiceSet(model, 7, number);
      const Calibration result = calibrate(set.set.board, set.set.views, {.model = "auto"});
      EXPECT_LT(shareAstray(set.drawn.camera, set.set.views, result), 0.1) << model << " " << number;
    }
  }
  EXPECT_EQ(num_sets, 9);
}

}  // namespace
}  // namespace alidade
