// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/uncertainty/aligned_difference.h"
#include "alidade/core/error.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{.width = 1280, .height = 960};

// Equidistant, apart from a little; the image's corners are this far from the axis.
AnyCamera fisheye(double half_field_deg, double s1_m) {
  const double focal = 800 / (half_field_deg * std::numbers::pi / 180);
  return AnyCamera::make("kannala_brandt",
                         std::vector<double>{focal, 1.001 * focal, 645, 474, 0.012, -0.005, 0.002, -0.0005})
      .withPupil({.s1_m = s1_m});
}

SimulatedSet setOf(double half_field_deg, double s1_m, int num_views, std::uint64_t seed) {
  return simulateSet(fisheye(half_field_deg, s1_m), kSize, num_views, 0.1, seed,
                     {.max_tilt_deg = 35, .min_fill = 0.2, .max_fill = 0.9});
}

// The difference to the truth of far points, px, which 95 % do not exceed; the image's corners are left out.
double errorOf(const Calibration& calibration, const AnyCamera& truth) {
  std::vector<Eigen::Vector2d> pixels;
  for (double v = 150; v < 840; v += 60) {
    for (double u = 200; u < 1100; u += 60) pixels.emplace_back(u, v);
  }
  std::vector<double> errors = alignedDifferences(calibration.camera(), truth, pixels, pixels,
                                                  std::numeric_limits<double>::infinity());
  std::ranges::sort(errors);
  return errors[errors.size() * 95 / 100];
}

TEST(Pupils, AreFoundWhereTheyMove) {
  int num_sets = 0;
  int num_found = 0;
  int num_covered = 0;
  int num_trustworthy = 0;
  double squares = 0;
  for (const double half_field_deg : {65, 80, 95}) {
    for (const double s1_m : {0.0005, 0.0012, 0.003, -0.001}) {
      const SimulatedSet set = setOf(half_field_deg, s1_m, 30, 100 + static_cast<std::uint64_t>(num_sets));
      const Calibration found = calibrate(set.board, set.views, {.model = "kannala_brandt"});
      ++num_sets;
      if (found.uncertainty.pupil_std_m.size() != 1) continue;
      ++num_found;
      const double sigmas = (found.camera().pupil().s1_m - s1_m) / found.uncertainty.pupil_std_m.front();
      num_covered += std::abs(sigmas) < 1.96 ? 1 : 0;
      squares += sigmas * sigmas;
      num_trustworthy += found.verdict() == Verdict::kTrustworthy ? 1 : 0;
      EXPECT_LT(errorOf(found, set.camera), 1.5 * found.uncertainty.accuracy->covered_px);
    }
  }
  EXPECT_EQ(num_sets, 12);
  EXPECT_GE(num_found, 11);  // half a millimetre at 65 degrees is not certain
  EXPECT_GE(num_covered, num_found - 1);
  EXPECT_GE(num_trustworthy, num_found - 1);  // the boards of one set do not cover the image
  EXPECT_LT(std::sqrt(squares / num_found), 1.3);
}

// A camera of the same views without the effect is as accurate.
TEST(Pupils, CostLittleAccuracy) {
  double with = 0;
  double without = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    for (const double s1_m : {0.0, 0.0015}) {
      const SimulatedSet set = setOf(80, s1_m, 40, seed);
      (s1_m > 0 ? with : without) += errorOf(calibrate(set.board, set.views), set.camera);
    }
  }
  EXPECT_LT(with, 2.5 * without);  // one more unknown
}

TEST(Pupils, AreNotInvented) {
  int num_sets = 0;
  for (const double half_field_deg : {35, 65, 95}) {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
      const SimulatedSet set = setOf(half_field_deg, 0, 25, seed);
      const Calibration found = calibrate(set.board, set.views, {.model = "kannala_brandt"});
      EXPECT_TRUE(found.uncertainty.pupil_std_m.empty()) << half_field_deg << " " << seed;
      EXPECT_TRUE(found.camera().pupil().isFixed());
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 12);
}

// A stiff model would leave its own misfit to the pupil.
TEST(Pupils, MoveInModelsThatFollowTheLens) {
  const SimulatedSet set = setOf(80, 0.0015, 30, 5);
  const Calibration found = calibrate(set.board, set.views);
  ASSERT_EQ(found.uncertainty.pupil_std_m.size(), 1U);
  EXPECT_EQ(found.camera().modelId(), "kannala_brandt");
  EXPECT_NEAR(found.camera().pupil().s1_m, 0.0015, 3 * found.uncertainty.pupil_std_m.front());
  ASSERT_TRUE(found.choice.pupil_excess);
  EXPECT_TRUE(found.choice.pupil_excess->is_significant);
}

TEST(Pupils, AreEstimatedOnRequest) {
  const SimulatedSet set = setOf(80, 0.0015, 25, 6);
  for (const std::size_t num : {0U, 1U, 2U}) {
    const Calibration found = calibrate(set.board, set.views, {.model = "kannala_brandt", .num_pupil = num});
    EXPECT_EQ(found.uncertainty.pupil_std_m.size(), num);
    // With a fixed pupil, the finding stays.
    const bool is_named = std::ranges::any_of(
        found.diagnoses, [](const Diagnosis& d) { return std::string_view(d.id) == "centre_moves"; });
    EXPECT_EQ(is_named, num == 0);
    // The parameters of the lens alone are stated.
    EXPECT_EQ(found.uncertainty.covariance->rows(), 8);
    EXPECT_EQ(found.uncertainty.information.rows(), 8);
    EXPECT_EQ(found.uncertainty.free_directions.rows(), 8);
  }
  EXPECT_THROW(static_cast<void>(calibrate(set.board, set.views, {.num_pupil = 3})), Error);
}

// A stated covariance includes that the pupil is unknown.
TEST(Pupils, WidenTheLens) {
  const SimulatedSet set = setOf(80, 0.0015, 25, 7);
  const Calibration one = calibrate(set.board, set.views, {.model = "kannala_brandt", .num_pupil = 1});
  const Calibration two = calibrate(set.board, set.views, {.model = "kannala_brandt", .num_pupil = 2});
  EXPECT_GT(two.uncertainty.parameterStdByNoise(0), 1.05 * one.uncertainty.parameterStdByNoise(0));
  // The information is the inverse of the covariance.
  const Eigen::MatrixXd covariance = *one.uncertainty.covariance;
  const Eigen::MatrixXd information = one.uncertainty.information;
  const double variance = std::pow(one.uncertainty.coordinate_sigma_px, 2);
  EXPECT_NEAR((covariance * information / variance - Eigen::MatrixXd::Identity(8, 8)).norm(), 0, 1e-5);
}

TEST(Pupils, AreInTheRecord) {
  const SimulatedSet set = setOf(80, 0.0015, 25, 8);
  const Calibration found = calibrate(set.board, set.views, {.model = "kannala_brandt"});
  const CameraRecord record = recordOf(found, "test");
  EXPECT_EQ(record.camera.pupil(), found.camera().pupil());
  EXPECT_EQ(record.calibration->pupil_std, found.uncertainty.pupil_std_m);
  EXPECT_EQ(record.calibration->parameter_std.size(), 8U);
  EXPECT_TRUE(runSelfCheck(record.camera, record.image_size, record.self_check).isPassed());
}

// A model without lens parameters, and views that do not determine the lens.
TEST(Pupils, LeaveLensesThatAreNotDetermined) {
  const AnyCamera pinhole =
      AnyCamera::make("pinhole", std::vector<double>{520, 521, 645, 474}).withPupil({.s1_m = 0.003});
  const SimulatedSet set =
      simulateSet(pinhole, kSize, 25, 0.1, 9, {.max_tilt_deg = 35, .min_fill = 0.2, .max_fill = 0.6});
  const Calibration found = calibrate(set.board, set.views, {.model = "pinhole"});
  ASSERT_EQ(found.uncertainty.pupil_std_m.size(), 1U);
  EXPECT_NEAR(found.camera().pupil().s1_m, 0.003, 3 * found.uncertainty.pupil_std_m.front());
  int num_checked = 0;
  for (const std::string& model : modelIds()) {
    for (const std::size_t num : {1U, 2U}) {
      const SimulatedSet few = setOf(60, 0.001, 5, 10);
      try {
        const Calibration of_few = calibrate(few.board, few.views, {.model = model, .num_pupil = num});
        EXPECT_EQ(of_few.choice.is_pupil_undetermined, of_few.camera().pupil().isFixed());
      } catch (const Error& error) {  // no camera of the model, or a pupil that no lens has
        EXPECT_EQ(error.code(), ErrorCode::kInput);
      }
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 2 * static_cast<int>(modelIds().size()));
}

// Of lengths in a wrong unit; the calibration without a pupil is kept.
TEST(Pupils, AreNotMetresLong) {
  SimulatedSet set = setOf(80, 0.0015, 25, 11);
  set.board.square_m *= 100;
  const Calibration found = calibrate(set.board, set.views, {.model = "kannala_brandt"});
  EXPECT_TRUE(found.camera().pupil().isFixed());
  EXPECT_THROW(
      static_cast<void>(calibrate(set.board, set.views, {.model = "kannala_brandt", .num_pupil = 1})), Error);
}

// A given lens keeps its pupil.
TEST(Pupils, AreGivenWithTheLens) {
  const SimulatedSet set = setOf(80, 0.0015, 12, 12);
  CalibratorOptions options{.initial = InitialCamera{.camera = set.camera, .size = kSize}};
  for (const std::string_view name : set.camera.parameterNames()) options.held.emplace_back(name);
  const Calibration found = calibrate(set.board, set.views, options);
  EXPECT_EQ(found.camera().pupil(), set.camera.pupil());
  EXPECT_LT(found.uncertainty.coordinate_sigma_px, 0.11);
}

}  // namespace
}  // namespace alidade
