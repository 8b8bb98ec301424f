// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/fold_guard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <ceres/cost_function.h>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/camera/image_domain.h"
#include "alidade/core/median.h"
#include "alidade/core/random.h"
#include "support/fit_set.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

bool isFolded(const Fit& fit) {
  return foldsInsideImage(cameraOf(fit), onlyCamera(fit).size);
}

// Solves with guards until the lens no longer folds.
Fit unfolded(Fit fit, double sigma_px) {
  for (int round = 0; round < 8 && guardFold(sigma_px, onlyCamera(fit)); ++round) fit = solve(std::move(fit));
  return fit;
}

// Rise of twice the cost of the corners by a guard, in variances.
double riseOf(const Fit& kept, const Fit& free, double sigma_px) {
  return 2 * (cornersCost(kept) - cornersCost(free)) / (sigma_px * sigma_px);
}

// Views of a lens without the corners beyond a distance from the centre of the image.
SimulatedSet middleOf(const AnyCamera& truth, double radius_px, double noise_px, std::uint64_t seed) {
  SimulatedSet set = simulateSet(truth, kQuadVga, 12, noise_px, seed);
  for (View& view : set.views) {
    std::erase_if(view.corners,
                  [&](const Corner& c) { return (c.pixel - Eigen::Vector2d(640, 480)).norm() > radius_px; });
  }
  std::erase_if(set.views, [](const View& view) { return view.corners.size() < 18; });
  return set;
}

constexpr double kFarOffPx = 1000;

// RMS error of rays near the corners of the image, px; far off where the camera has no pixel.
double errorInCorners(const Fit& fit, const AnyCamera& truth) {
  const AnyCamera found = cameraOf(fit);
  double sum = 0;
  for (const double x : {10.0, 1269.0}) {
    for (const double y : {10.0, 949.0}) {
      const Projection to = found.project(*truth.unproject({x, y}));
      const double error = to.ok() ? (to.pixel - Eigen::Vector2d(x, y)).norm() : kFarOffPx;
      sum += std::min(error, kFarOffPx) * std::min(error, kFarOffPx);
    }
  }
  return std::sqrt(sum / 4);
}

TEST(FoldGuard, DerivativesAreThoseOfTheResiduals) {
  int num_derivatives = 0;
  int num_acting = 0;
  const std::vector<std::pair<std::string, std::vector<double>>> lenses = {
      {"radtan", {900, 905, 640, 480, -0.28, 0.09, 5e-4, -4e-4, -0.1}},
      {"kannala_brandt", {600, 605, 640, 480, 0.1, -0.2, -0.1, -0.1}}};
  for (const auto& [model, params] : lenses) {
    FitCamera camera{.model = model, .size = kQuadVga, .params = params};
    ASSERT_TRUE(guardFold(0.1, camera)) << model;
    const FoldGuard& guard = camera.weak_prior.guard;
    const std::unique_ptr<ceres::CostFunction> block(foldGuardBlock(model, guard));
    const std::size_t n = params.size();
    const std::size_t num_rays = guard.rays.size();
    const auto at = [&](const std::vector<double>& where, double* jacobian) {
      std::vector<double> residuals(num_rays);
      const double* blocks = where.data();
      EXPECT_TRUE(block->Evaluate(&blocks, residuals.data(), jacobian == nullptr ? nullptr : &jacobian));
      return residuals;
    };
    std::vector<double> jacobian(num_rays * n);
    const std::vector<double> residuals = at(params, jacobian.data());
    num_acting += static_cast<int>(std::ranges::count_if(residuals, [](double r) { return r > 0.1; }));
    for (std::size_t p = 0; p < n; ++p) {
      constexpr double kStep = 1e-6;
      std::vector<double> more = params;
      std::vector<double> less = params;
      more[p] += kStep;
      less[p] -= kStep;
      const std::vector<double> above = at(more, nullptr);
      const std::vector<double> below = at(less, nullptr);
      for (std::size_t i = 0; i < num_rays; ++i) {
        const double numeric = (above[i] - below[i]) / (2 * kStep);
        EXPECT_NEAR(jacobian[i * n + p], numeric, 1e-4 * std::max(1.0, std::abs(numeric)));
        ++num_derivatives;
      }
    }
  }
  EXPECT_GE(num_acting, 20);
  EXPECT_GE(num_derivatives, 500);
}

TEST(FoldGuard, UnfoldsALensInCornersThatNoBoardReached) {
  const AnyCamera truth =
      AnyCamera::make("radtan", std::vector<double>{900, 900, 640, 480, -0.28, 0.09, 5e-4, -4e-4, -0.012});
  constexpr double kCornerNoisePx = 0.3;
  int num_sets = 0;
  int num_folded = 0;
  std::vector<double> errors_px;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const SimulatedSet set = middleOf(truth, 400, kCornerNoisePx, seed);
    if (set.views.size() < 8) continue;
    ++num_sets;
    const Fit free = settledFromStart(fitAt(set, truth), nullptr).fit;
    if (!isFolded(free)) continue;
    const Fit kept = unfolded(free, kCornerNoisePx);
    EXPECT_FALSE(isFolded(kept)) << seed;
    EXPECT_LT(riseOf(kept, free, kCornerNoisePx), 25) << seed;
    ++num_folded;
    errors_px.push_back(errorInCorners(kept, truth));
    EXPECT_LT(errors_px.back(), kFarOffPx) << "a corner of the image without a ray";
  }
  std::printf("%d of %d sets fold; unfolded, the corners are off by a median of %.1f px\n", num_folded,
              num_sets, errors_px.empty() ? 0.0 : medianOf(errors_px));
  EXPECT_GE(num_sets, 20);
  EXPECT_GE(num_folded, 5);
}

// A lens that folds in the image, and corners that reach nearly to its fold.
TEST(FoldGuard, ContradictsCornersThatShowAFold) {
  constexpr double kCornerNoisePx = 0.05;
  constexpr double kReachPx = 440;  // it folds at 476 px
  const AnyCamera plain = AnyCamera::make("radtan", std::vector<double>{700, 700, 640, 480, 0, 0, 0, 0, 0});
  const AnyCamera folding =
      AnyCamera::make("radtan", std::vector<double>{700, 700, 640, 480, -0.32, 0, 0, 0, 0});
  int num_folded = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(streamSeed(5, seed));
    Fit fit = fitAt(simulateSet(plain, kQuadVga, 12, 0, seed), folding);
    for (FitView& view : fit.views) {
      const SE3 pose = cameraFromBoard(fit, view);
      std::erase_if(view.corners, [&](Observation& corner) {
        const Projection to = folding.project(pose * corner.p_board);
        corner.pixel = to.pixel + kCornerNoisePx * Eigen::Vector2d(random.normal(), random.normal());
        return !to.ok() || (to.pixel - Eigen::Vector2d(640, 480)).norm() > kReachPx;
      });
    }
    std::vector<bool> is_out;
    for (const FitView& view : fit.views) is_out.push_back(view.corners.size() < 18);
    const Fit free = settledFromStart(withoutViews(fit, is_out), nullptr).fit;
    if (!isFolded(free)) continue;
    EXPECT_GT(riseOf(unfolded(free, kCornerNoisePx), free, kCornerNoisePx), 25) << seed;
    ++num_folded;
  }
  EXPECT_GE(num_folded, 8);
}

}  // namespace
}  // namespace alidade
