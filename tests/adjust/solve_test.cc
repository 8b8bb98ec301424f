// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/solve.h"

#include <gtest/gtest.h>

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/reduced.h"
#include "alidade/adjust/board/view_block.h"
#include "alidade/adjust/noise/covariance.h"
#include "support/bundle_set.h"
#include "support/corner_cost.h"

namespace alidade {
namespace {

constexpr HuberLoss kSolveLoss{.threshold_px = 1.5};
constexpr double kSolveOutlierPx = 15;

std::vector<PoseBlock> blocksOf(const Fit& fit) {
  std::vector<PoseBlock> blocks;
  for (const FitView& view : fit.views) blocks.push_back(toBlock(cameraFromBoard(fit, view)));
  return blocks;
}

template <class M>
class SolveOf : public testing::Test {};
TYPED_TEST_SUITE(SolveOf, AllModelTypes, ModelName);

TYPED_TEST(SolveOf, CostAndGradientOfAViewEqualThoseOfItsCornersUnderCeresLoss) {
  using M = TypeParam;
  const Fit fit = bundleSet<M>(5, kSolveOutlierPx, kSolveLoss);
  auto poses = blocksOf(fit);
  std::vector<double> params = fit.cameras.front().params;
  ceres::Problem plain;
  addCorners<M>(plain, cornersOf(fit), new ceres::HuberLoss(kSolveLoss.threshold_px), params, poses);
  ceres::Problem by_views;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    by_views.AddResidualBlock(new ViewBlock(fit, fit.views[v]), nullptr, params.data(), poses[v].data());
    by_views.SetManifold(poses[v].data(), new SE3Manifold);
  }
  ceres::Problem::EvaluateOptions order;
  order.parameter_blocks = {params.data()};
  for (PoseBlock& pose : poses) order.parameter_blocks.push_back(pose.data());
  double cost = 0;
  double cost_alone = 0;
  double plain_cost = 0;
  std::vector<double> gradient;
  std::vector<double> plain_gradient;
  ASSERT_TRUE(by_views.Evaluate(order, &cost_alone, nullptr, nullptr, nullptr));
  ASSERT_TRUE(by_views.Evaluate(order, &cost, nullptr, &gradient, nullptr));
  ASSERT_TRUE(plain.Evaluate(order, &plain_cost, nullptr, &plain_gradient, nullptr));
  EXPECT_NEAR(cost, plain_cost, 1e-12 * plain_cost);
  EXPECT_NEAR(cost_alone, plain_cost, 1e-12 * plain_cost);
  ASSERT_EQ(gradient.size(), plain_gradient.size());
  ASSERT_EQ(gradient.size(), static_cast<std::size_t>(kNumParams<M> + 5 * 6));
  for (std::size_t i = 0; i < gradient.size(); ++i)
    EXPECT_NEAR(gradient[i], plain_gradient[i], 1e-9 * (1 + std::abs(plain_gradient[i]))) << i;
}

// By all unknowns that a view may have: intrinsics, placement, the places of the camera in a rig and of the
// board in a body, the board's shape.
TYPED_TEST(SolveOf, JacobianOfAViewIsThatOfItsCost) {
  using M = TypeParam;
  Fit fit = bundleSet<M>(1, kSolveOutlierPx, kSolveLoss);
  fit.cameras.front().is_rig_pose_fixed = false;
  fit.cameras.front().camera_from_rig =
      SE3::exp((SE3::Vec6() << 0.01, -0.02, 0.03, 0.1, -0.2, 0.05).finished());
  fit.boards.front().body_from_board = SE3::exp((SE3::Vec6() << 0.3, 0.2, -0.1, -0.5, 0.4, 0.7).finished());
  fit.placements.front().rig_from_body = fit.cameras.front().camera_from_rig.inverse() *
                                         fit.placements.front().rig_from_body *
                                         fit.boards.front().body_from_board->inverse();
  fit.boards.front().is_shape_fixed = false;
  std::vector<double> params = fit.cameras.front().params;
  PoseBlock placement = toBlock(fit.placements.front().rig_from_body);
  PoseBlock rig_pose = toBlock(fit.cameras.front().camera_from_rig);
  PoseBlock body_pose = toBlock(*fit.boards.front().body_from_board);
  std::array<double, 2> shape = {2e-4, -3e-4};
  ceres::Problem problem;
  problem.AddResidualBlock(new ViewBlock(fit, fit.views.front()), nullptr, params.data(), placement.data(),
                           rig_pose.data(), body_pose.data(), shape.data());
  problem.SetManifold(body_pose.data(), new SE3Manifold);
  problem.SetManifold(placement.data(), new SE3Manifold);
  problem.SetManifold(rig_pose.data(), new SE3Manifold);
  ceres::Problem::EvaluateOptions order;
  order.parameter_blocks = {params.data(), placement.data(), rig_pose.data(), body_pose.data(), shape.data()};
  std::vector<double> gradient;
  ceres::CRSMatrix jacobian;
  double cost = 0;
  ASSERT_TRUE(problem.Evaluate(order, &cost, nullptr, &gradient, &jacobian));
  std::vector<double> curvature(gradient.size());
  for (std::size_t k = 0; k < jacobian.values.size(); ++k)
    curvature[static_cast<std::size_t>(jacobian.cols[k])] += jacobian.values[k] * jacobian.values[k];
  const auto costNow = [&] {
    double now = 0;
    EXPECT_TRUE(problem.Evaluate(order, &now, nullptr, nullptr, nullptr));
    return now;
  };
  // Moves one unknown, of a pose along its tangent.
  const auto costAt = [&](std::size_t i, double step) {
    const auto n = static_cast<std::size_t>(kNumParams<M>);
    const auto before = std::tuple(params, placement, rig_pose, body_pose, shape);
    if (i < n) {
      params[i] += step;
    } else if (i < n + 18) {
      PoseBlock& pose = i < n + 6 ? placement : i < n + 12 ? rig_pose : body_pose;
      SE3::Vec6 xi = SE3::Vec6::Zero();
      xi(static_cast<Eigen::Index>((i - n) % 6)) = step;
      pose = toBlock(fromBlock(pose.data()) * SE3::exp(xi));
    } else {
      shape[i - n - 18] += step;
    }
    const double now = costNow();
    std::tie(params, placement, rig_pose, body_pose, shape) = before;
    return now;
  };
  int num_checked = 0;
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    const double h = 1e-5 * std::sqrt(cost / curvature[i]);
    EXPECT_NEAR((costAt(i, h) - costAt(i, -h)) / (2 * h), gradient[i], 2e-7 * std::sqrt(cost * curvature[i]))
        << i;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumParams<M> + 6 + 6 + 6 + 2);
}

// Where both end, as the root mean square of a corner and in standard deviations of the parameters.
template <class M>
void expectOptimumOfPlainCeres(double outlier_px) {
  constexpr double kTight = 1e-18;  // by default, the last step may be one of a millionth of a sigma
  Fit fit = bundleSet<M>(12, outlier_px, kSolveLoss);
  auto poses = blocksOf(fit);
  std::vector<double> params = fit.cameras.front().params;
  ceres::Problem plain;
  addCorners<M>(plain, cornersOf(fit), new ceres::HuberLoss(kSolveLoss.threshold_px), params, poses);
  if (const auto redundant = parameterIndex(kParamNames<M>, M::kRedundant)) {
    const int held = static_cast<int>(*redundant);
    fit.cameras.front().constraint.held = {held};
    plain.SetManifold(params.data(), new ceres::SubsetManifold(kNumParams<M>, {held}));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = kTight;
  options.parameter_tolerance = 1e-14;
  options.gradient_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary plain_summary;
  ceres::Solve(options, &plain, &plain_summary);
  ASSERT_EQ(plain_summary.termination_type, ceres::CONVERGENCE) << plain_summary.message;

  fit = solve(std::move(fit), {.function_tolerance = kTight});
  const SolveSummary& summary = fit.summary;
  ASSERT_EQ(summary.termination, Termination::kConverged) << summary.reason;
  // The RMS goes with the root of the cost.
  constexpr double kRelativeRms = 1e-8;
  EXPECT_NEAR(std::sqrt(summary.cost / plain_summary.final_cost), 1.0, kRelativeRms);

  const auto inverse = intrinsicsInformation(fit).inverse;
  ASSERT_TRUE(inverse);
  constexpr double kNoisePx = 0.2;
  // A step of Gauss and Newton's method from here, in standard deviations: how far the optimum is.
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(inverse->rows());
  for (const Reduced& view : reduced(fit, LossWeights::kUse)) gradient += view.gradient;
  // Coefficients of a numerator and a denominator make up for each other; of projections that are iterated
  // from high powers of pixels, the last digits are lost.
  constexpr bool kIsValley =
      kNumParams < M >> 9 || std::is_same_v<M, InverseBrown> || std::is_same_v<M, FThetaInverse>;
  // Whoever compares costs stops where these have no more digits, which is worth their root in sigmas. They
  // are sums over a thousand residuals: those of the two solvers differ by up to 90 of their last digits.
  const double rounding = std::sqrt(2 * std::numeric_limits<double>::epsilon() * summary.cost) / kNoisePx;
  EXPECT_LE(std::sqrt(gradient.dot(*inverse * gradient)) / kNoisePx,
            std::max(kIsValley ? 1e-5 : 1e-6, 2 * rounding));
  const double kSigmas = std::max(kIsValley ? 2e-5 : 2e-6, 2 * rounding);  // plain Ceres does so, too
  for (std::size_t i = 0; i < params.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double sigma = kNoisePx * std::sqrt((*inverse)(k, k));
    EXPECT_NEAR(fit.cameras.front().params[i], params[i], kSigmas * sigma) << kParamNames<M>[i];
  }
  const AnyCamera camera = AnyCamera::make(M::kId, fit.cameras.front().params);
  const AnyCamera plain_camera = AnyCamera::make(M::kId, params);
  const double kTolerancePx = std::max(kIsValley ? 1e-5 : 1e-6, 2 * rounding * kNoisePx);
  int num_checked = 0;
  for (double angle = 0; angle < 0.6; angle += 0.05) {
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d ray = rayAt(angle, k * std::numbers::pi / 4);
      Eigen::Matrix<double, 2, kNumParams<M>, Eigen::RowMajor> J;
      const Projection seen = camera.project(ray, nullptr, J.data());
      const Projection plainly = plain_camera.project(ray);
      ASSERT_EQ(seen.ok(), plainly.ok()) << angle;
      if (!seen.ok()) continue;  // the lens folds beyond the boards
      // Beyond the boards, what is not determined grows.
      const double sigma_px = kNoisePx * std::sqrt((J * *inverse * J.transpose()).trace());
      EXPECT_LE((seen.pixel - plainly.pixel).norm(), std::max(kTolerancePx, kSigmas * sigma_px)) << angle;
      ++num_checked;
    }
  }
  EXPECT_GE(num_checked, 7 * 8);
  if (outlier_px == 0) {
    EXPECT_EQ(num_checked, 12 * 8);
  }
}

TYPED_TEST(SolveOf, ReachesTheOptimumOfPlainCeres) {
  expectOptimumOfPlainCeres<TypeParam>(0);
}

TYPED_TEST(SolveOf, ReachesTheOptimumOfPlainCeresDespiteOutliers) {
  expectOptimumOfPlainCeres<TypeParam>(kSolveOutlierPx);
}

TYPED_TEST(SolveOf, GivesTheSameBytesAgain) {
  using M = TypeParam;
  const Fit fit = bundleSet<M>(6, kSolveOutlierPx, kSolveLoss);
  const Fit first = solve(fit);
  const Fit second = solve(fit);
  EXPECT_EQ(first.summary.cost, second.summary.cost);
  EXPECT_EQ(first.cameras.front().params, second.cameras.front().params);
  EXPECT_EQ(blocksOf(first), blocksOf(second));
  EXPECT_EQ(blocksOf(first).size(), 6U);
}

// Ceres sorts blocks by their addresses, and the order of a sum decides how it is rounded.
TEST(Solve, GivesTheSameBytesWhereverItsBlocksLieInMemory) {
  Fit fit = bundleSet<Rational>(6, kSolveOutlierPx, kSolveLoss);
  onlyBoard(fit).is_shape_fixed = false;
  // A large vector lies far above what is allocated next, a small one among it.
  Fit far = fit;
  onlyCamera(far).params.reserve(std::size_t{1} << 22);
  std::vector<Fit> solved;
  solved.push_back(solve(fit));
  solved.push_back(solve(std::move(far)));
  EXPECT_EQ(solved[0].summary.cost, solved[1].summary.cost);
  EXPECT_EQ(onlyCamera(solved[0]).params, onlyCamera(solved[1]).params);
  EXPECT_EQ(onlyBoard(solved[0]).shape, onlyBoard(solved[1]).shape);
  EXPECT_EQ(blocksOf(solved[0]), blocksOf(solved[1]));
}

TEST(Solve, FailsFromBehindTheCamera) {
  Fit fit = bundleSet<Radtan>(4, 0, kSolveLoss);
  fit.placements[2].rig_from_body.translation.z() = -1;
  testing::internal::CaptureStderr();
  const SolveSummary summary = solve(fit).summary;
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(summary.termination, Termination::kFailed);
  EXPECT_TRUE(std::isnan(summary.cost));
}

// Where parameters make up for each other, no factorization may fail aloud.
TEST(Solve, SaysNothingOnStandardErrorAboutValleys) {
  int num_solved = 0;
  for (const int num_views : {1, 2, 3}) {
    const Fit fit = bundleSet<Rational>(num_views, kSolveOutlierPx, kSolveLoss);
    testing::internal::CaptureStderr();
    const SolveSummary summary = solve(fit).summary;
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << num_views;
    EXPECT_NE(summary.termination, Termination::kFailed) << summary.reason;
    ++num_solved;
  }
  EXPECT_EQ(num_solved, 3);
}

// With nothing left of the parameters the views have nothing to do with each other.
TEST(Solve, SolvesPosesAloneWhereAllParametersAreFixed) {
  Fit fit = bundleSet<Radtan>(4, 0, kSolveLoss);
  fit.cameras.front().constraint.held = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  const std::vector<double> params = fit.cameras.front().params;
  double sum = 0;
  std::vector<SE3> alone;
  for (std::size_t v = 0; v < 4; ++v) {
    std::vector<bool> is_out(4, true);
    is_out[v] = false;
    const Fit one = solve(withoutViews(fit, is_out));
    sum += one.summary.cost;
    alone.push_back(cameraFromBoard(one, one.views.front()));
  }
  fit = solve(std::move(fit));
  EXPECT_EQ(fit.summary.termination, Termination::kConverged) << fit.summary.reason;
  EXPECT_NEAR(fit.summary.cost, sum, 1e-9 * sum);
  EXPECT_EQ(fit.cameras.front().params, params);
  double errors = 0;
  for (std::size_t v = 0; v < 4; ++v) {
    const SE3 difference = alone[v].inverse() * cameraFromBoard(fit, fit.views[v]);
    EXPECT_LE(difference.log().norm(), 1e-6) << v;
    for (std::size_t i = 0; i < fit.views[v].errors.size(); ++i) {
      errors += 0.5 * kSolveLoss.rho(fit.views[v].corners[i].weight * fit.views[v].errors[i].squaredNorm());
    }
  }
  EXPECT_NEAR(errors, fit.summary.cost, 1e-9 * errors);
}

TEST(Solve, ReportsTheIterationLimit) {
  const SolveSummary summary = solve(bundleSet<Radtan>(4, 0, kSolveLoss), {.max_iterations = 2}).summary;
  EXPECT_EQ(summary.termination, Termination::kIterationLimit);
  EXPECT_EQ(summary.num_iterations, 2);
}

// Two cameras of different models see the same boards: one solver, a longer list of cameras.
TEST(Solve, FindsTheCamerasOfARig) {
  const std::vector<double> left = {1003, 1001, 645, 475, -0.2, 0.05, 8e-4, -4e-4, -0.01};
  const std::vector<double> right = {700, 701, 635, 482, -0.01, 0.02, -0.01, 0.002};
  const SE3 right_from_left = SE3::exp((SE3::Vec6() << -0.12, 0.01, 0.005, 0.02, -0.05, 0.01).finished());
  const SimulatedSet set = simulateSet(AnyCamera::make("radtan", left), kTestImage, 12, 0, 3);
  const AnyCamera other = AnyCamera::make("kannala_brandt", right);
  Fit fit = fitAt(set, "radtan", left, kSolveLoss);
  fit.cameras.push_back({.model = "kannala_brandt",
                         .size = kTestImage,
                         .params = right,
                         .camera_from_rig = right_from_left,
                         .is_rig_pose_fixed = false});
  Random random(9);
  for (std::size_t p = 0; p < fit.placements.size(); ++p) {
    View view = exactView(other, kTestImage, set.board, right_from_left * set.poses[p], "right");
    if (view.corners.size() < 20) continue;
    addCornerNoise(view, 0.1, random);
    fit.views.push_back({.camera = 1, .placement = p, .corners = observationsOf(set.board, view)});
  }
  ASSERT_GE(fit.views.size(), 18U);
  // Beside the truth.
  fit.cameras[0].params[0] *= 1.01;
  fit.cameras[1].params[1] *= 0.99;
  fit.cameras[1].camera_from_rig =
      right_from_left * SE3::exp((SE3::Vec6() << 0.01, 0, -0.01, 0.01, 0, 0.01).finished());
  fit = solve(std::move(fit));
  ASSERT_EQ(fit.summary.termination, Termination::kConverged) << fit.summary.reason;
  EXPECT_NEAR(fit.cameras[0].params[0], left[0], 1);
  EXPECT_NEAR(fit.cameras[1].params[1], right[1], 1);
  const SE3 error = right_from_left.inverse() * fit.cameras[1].camera_from_rig;
  EXPECT_LE(error.translation.norm(), 5e-4);
  EXPECT_LE(error.rotation.log().norm(), 2e-3);
  EXPECT_LE(rms(fit), 0.1 * std::sqrt(2.0));
}

}  // namespace
}  // namespace alidade
