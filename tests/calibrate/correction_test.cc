// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/uncertainty/aligned_difference.h"
#include "alidade/camera/correction_field.h"
#include "alidade/core/error.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr ImageSize kFrame{.width = 1280, .height = 960};

// Long waves in random directions without their affine part, which is no deviation; this RMS over the image,
// px.
std::shared_ptr<const CorrectionField> waves(double rms_px, std::uint64_t seed) {
  const CorrectionGrid grid = CorrectionGrid::over(kFrame, 20, 15);
  Random random(seed);
  Eigen::MatrixXd basis(grid.numPoints(), 3);
  Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(grid.numPoints(), 2);
  for (int i = 0; i < grid.numPoints(); ++i) {
    basis.row(i) << 1, (i % grid.pointsAcross() - 1) * grid.cell_px.x(),
        (i / grid.pointsAcross() - 1) * grid.cell_px.y();
  }
  for (int wave = 0; wave < 12; ++wave) {
    const Eigen::Vector2d along =
        2 * std::numbers::pi / kFrame.width * Eigen::Vector2d(random.normal(), random.normal());
    const double phase = random.uniform(0, 2 * std::numbers::pi);
    const Eigen::RowVector2d height(random.normal(), random.normal());
    for (int i = 0; i < grid.numPoints(); ++i)
      moves.row(i) += std::sin(basis.row(i).tail<2>().dot(along) + phase) * height;
  }
  moves -= basis * (basis.transpose() * basis).ldlt().solve(basis.transpose() * moves);
  moves *= rms_px / std::sqrt(moves.squaredNorm() / static_cast<double>(moves.rows()));
  std::vector<double> points;
  for (int i = 0; i < grid.numPoints(); ++i) points.insert(points.end(), {moves(i, 0), moves(i, 1)});
  return std::make_shared<const CorrectionField>(grid, points);
}

AnyCamera lensOf(std::string_view model) {
  if (model == "radtan") {
    return AnyCamera::make(model, std::vector<double>{900, 901, 645, 474, -0.2, 0.06, 0.0005, -0.0004, 0});
  }
  return AnyCamera::make(model, std::vector<double>{480, 481, 645, 474, 0.012, -0.005, 0.002, -0.0005});
}

SimulatedSet wavySet(const AnyCamera& camera, int num_views, std::uint64_t seed) {
  SimulatedSet set = simulateSet(camera, kFrame, num_views, 0.1, seed,
                                 {.max_tilt_deg = 40, .min_fill = 0.3, .max_fill = 0.8},
                                 {.columns = 13, .rows = 9, .square_m = 0.03});
  dropOutside(set.views);
  return set;
}

// The difference to the truth of far points, px, which 95 % do not exceed.
double farErrorOf(const Calibration& calibration, const AnyCamera& truth) {
  std::vector<Eigen::Vector2d> pixels;
  for (double v = 80; v < 900; v += 50) {
    for (double u = 100; u < 1200; u += 50) pixels.emplace_back(u, v);
  }
  std::vector<double> errors = alignedDifferences(calibration.camera(), truth, pixels, pixels,
                                                  std::numeric_limits<double>::infinity());
  std::ranges::sort(errors);
  return errors[errors.size() * 95 / 100];
}

constexpr double kNoiseRms = 0.1 * std::numbers::sqrt2;

TEST(Corrections, AreFoundWhereLensesDeviate) {
  int num_sets = 0;
  int num_found = 0;
  int num_trustworthy = 0;
  int num_within = 0;
  double errors = 0;
  double errors_without = 0;
  for (const std::string_view model : {"radtan", "kannala_brandt"}) {
    for (const double rms_px : {0.1, 0.3, 0.5}) {
      for (int k = 0; k < 2; ++k) {
        const auto seed = static_cast<std::uint64_t>(40 + num_sets++);
        const AnyCamera truth = lensOf(model).withCorrection(waves(rms_px, seed));
        const SimulatedSet set = wavySet(truth, 40, seed);
        const Calibration found = calibrate(set.board, set.views);
        const Calibration without = calibrate(set.board, set.views, {.correction_cells = {{0, 0}}});
        EXPECT_EQ(without.camera().correction(), nullptr);
        if (found.camera().correction() == nullptr) continue;
        ++num_found;
        num_trustworthy += found.verdict() == Verdict::kTrustworthy ? 1 : 0;
        EXPECT_LT(found.uncertainty.holdout.rms_px, 1.05 * kNoiseRms);
        const double error = farErrorOf(found, truth);
        num_within += error < found.uncertainty.accuracy->covered_px ? 1 : 0;
        errors += error * error;
        errors_without += std::pow(farErrorOf(without, truth), 2);
      }
    }
  }
  EXPECT_EQ(num_sets, 12);
  EXPECT_EQ(num_found, num_sets);
  EXPECT_EQ(num_trustworthy, num_sets);
  EXPECT_GE(num_within, num_sets - 1);  // 92 %
  EXPECT_LT(std::sqrt(errors / errors_without), 1.0 / 3);
}

TEST(Corrections, AreNotUsedWithoutDeviation) {
  int num_sets = 0;
  for (const std::string_view model : {"radtan", "kannala_brandt"}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const SimulatedSet set = wavySet(lensOf(model), 20, 300 + seed);
      EXPECT_EQ(calibrate(set.board, set.views).camera().correction(), nullptr) << model << " " << seed;
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 10);
}

// The model's own numbers keep their meaning: the field takes only what they cannot.
TEST(Corrections, LeaveTheModelWhatItExplains) {
  const AnyCamera truth = lensOf("radtan").withCorrection(waves(0.2, 7));
  const SimulatedSet set = wavySet(truth, 40, 7);
  const Calibration found =
      calibrate(set.board, set.views, {.model = "radtan", .correction_cells = {{8, 6}}});
  ASSERT_NE(found.camera().correction(), nullptr);
  EXPECT_EQ(found.camera().correction()->grid().columns, 8);
  EXPECT_FALSE(found.choice.correction->excess);
  EXPECT_NEAR(found.camera().parameter("fx"), 900, 3);
  EXPECT_NEAR(found.choice.correction->rms_px, 0.2, 0.1);
  // Of a set without deviation, it takes next to nothing.
  const SimulatedSet plain = wavySet(lensOf("radtan"), 40, 8);
  const Calibration none =
      calibrate(plain.board, plain.views, {.model = "radtan", .correction_cells = {{8, 6}}});
  if (none.camera().correction() != nullptr) {
    EXPECT_LT(none.choice.correction->rms_px, 0.04);
    EXPECT_LT(farErrorOf(none, lensOf("radtan")), 0.3);
  }
}

// Views far away and near; the pupil is seen by the near ones only, and the field by all.
TEST(Corrections, AreKeptApartFromEntrancePupils) {
  const AnyCamera truth = lensOf("kannala_brandt").withCorrection(waves(0.3, 11)).withPupil({.s1_m = 0.003});
  SimulatedSet set =
      simulateSet(truth, kFrame, 60, 0.1, 11, {.max_tilt_deg = 35, .min_fill = 0.2, .max_fill = 0.9});
  dropOutside(set.views);
  const Calibration found = calibrate(set.board, set.views);
  ASSERT_EQ(found.uncertainty.pupil_std_m.size(), 1U);
  ASSERT_NE(found.camera().correction(), nullptr);
  EXPECT_LT(std::abs(found.camera().pupil().s1_m - 0.003), 2.5 * found.uncertainty.pupil_std_m.front());
  EXPECT_LT(farErrorOf(found, truth), found.uncertainty.accuracy->covered_px);
  EXPECT_LT(found.uncertainty.holdout.rms_px, 1.08 * kNoiseRms);
}

TEST(Corrections, OfGivenLensesAreKept) {
  const AnyCamera truth = lensOf("radtan").withCorrection(waves(0.4, 12));
  const SimulatedSet set = wavySet(truth, 8, 12);
  CalibratorOptions options{.initial = InitialCamera{.camera = truth, .size = kFrame}};
  for (const std::string_view name : truth.parameterNames()) options.held.emplace_back(name);
  const Calibration found = calibrate(set.board, set.views, options);
  EXPECT_EQ(found.camera().correction(), truth.correction());
  EXPECT_LT(found.uncertainty.holdout.rms_px, 1.1 * kNoiseRms);
  EXPECT_LT(farErrorOf(found, truth), 1e-6);
}

// Whatever is asked for ends without an internal error.
TEST(Corrections, OfFewViewsDoNoHarm) {
  int num_checked = 0;
  for (const int num_views : {3, 5, 8}) {
    for (const std::array<int, 2> cells : {std::array{1, 1}, std::array{6, 4}, std::array{16, 12}}) {
      const SimulatedSet set = wavySet(lensOf("radtan"), num_views, static_cast<std::uint64_t>(num_views));
      for (const char* const model : {"radtan", "auto"}) {
        const Calibration found =
            calibrate(set.board, set.views, {.model = model, .correction_cells = cells});
        EXPECT_GT(found.camera().parameter("fx"), 0);
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 18);
}

}  // namespace
}  // namespace alidade
