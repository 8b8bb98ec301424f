// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bundle_adjustment.h"

#include <gtest/gtest.h>

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "alidade/calibrate/bundle_problem.h"
#include "alidade/calibrate/covariance.h"
#include "support/bundle_set.h"
#include "support/corner_cost.h"

namespace alidade {
namespace {

constexpr HuberLoss kLoss{.threshold_px = 1.5};
constexpr double kOutlierPx = 15;

std::vector<PoseBlock> blocksOf(const std::vector<SE3>& poses) {
  std::vector<PoseBlock> blocks;
  for (const SE3& pose : poses) blocks.push_back(toBlock(pose));
  return blocks;
}

template <class M>
class BundleOf : public testing::Test {};
TYPED_TEST_SUITE(BundleOf, AllModelTypes, ModelName);

TYPED_TEST(BundleOf, CostAndGradientEqualThoseOfCornersUnderCeresLoss) {
  using M = TypeParam;
  BundleSet<M> set(5, kOutlierPx);
  auto poses = blocksOf(set.state.camera_from_board);
  std::vector<double> params = set.state.params;
  ceres::Problem plain;
  addCorners<M>(plain, set.views, new ceres::HuberLoss(kLoss.threshold_px), params, poses);
  BundleProblem bundle(M::kId, set.views, kLoss, set.state.params, set.state.camera_from_board);

  double cost = 0;
  double plain_cost = 0;
  std::vector<double> plain_gradient;
  // The parameters, then the poses.
  ceres::Problem::EvaluateOptions plain_order;
  plain_order.parameter_blocks = {params.data()};
  for (PoseBlock& pose : poses) plain_order.parameter_blocks.push_back(pose.data());
  ASSERT_TRUE(bundle.begin());
  ASSERT_TRUE(bundle.problem().Evaluate({}, &cost, nullptr, nullptr, nullptr));
  ASSERT_TRUE(plain.Evaluate(plain_order, &plain_cost, nullptr, &plain_gradient, nullptr));
  EXPECT_NEAR(cost, plain_cost, 1e-12 * plain_cost);
  const Eigen::VectorXd gradient = bundle.gradient();
  ASSERT_EQ(static_cast<std::size_t>(gradient.size()), plain_gradient.size());
  ASSERT_EQ(gradient.size(), kNumParams<M> + 5 * 6);
  for (std::size_t i = 0; i < plain_gradient.size(); ++i)
    EXPECT_NEAR(gradient(static_cast<Eigen::Index>(i)), plain_gradient[i],
                1e-9 * (1 + std::abs(plain_gradient[i])))
        << i;
}

// By the parameters, which the poses follow, and by the way of the poses: at the start and where a step has
// led, under any radius of the trust region.
TYPED_TEST(BundleOf, GradientOfWhatCeresSeesIsThatOfItsCost) {
  using M = TypeParam;
  int num_checked = 0;
  for (const double radius : {1e8, 1e4, 1.0, 1e-3}) {
    BundleSet<M> set(4, kOutlierPx);
    std::vector<double>& params = set.state.params;
    BundleProblem bundle(M::kId, set.views, kLoss, params, set.state.camera_from_board);
    ceres::Problem::EvaluateOptions order;
    order.parameter_blocks = {params.data(), bundle.path()};
    const auto costNow = [&] {
      double cost = 0;
      EXPECT_TRUE(bundle.problem().Evaluate(order, &cost, nullptr, nullptr, nullptr));
      return cost;
    };
    bundle.setRadius(radius);
    ASSERT_TRUE(bundle.begin());
    for (int at = 0; at < 2; ++at) {
      double cost = 0;
      std::vector<double> gradient;
      ceres::CRSMatrix jacobian;
      ASSERT_TRUE(bundle.problem().Evaluate(order, &cost, nullptr, &gradient, &jacobian));
      ASSERT_EQ(gradient.size(), params.size() + 1);
      std::vector<double> curvature(gradient.size());
      for (std::size_t k = 0; k < jacobian.values.size(); ++k)
        curvature[static_cast<std::size_t>(jacobian.cols[k])] += jacobian.values[k] * jacobian.values[k];
      EXPECT_NEAR(costNow(), cost, 1e-12 * cost);
      for (std::size_t i = 0; i < gradient.size(); ++i) {
        double& unknown = i < params.size() ? params[i] : *bundle.path();
        const double before = unknown;
        const double h = 1e-5 * std::sqrt(cost / curvature[i]);
        unknown = before + h;
        const double above = costNow();
        unknown = before - h;
        const double below = costNow();
        unknown = before;
        EXPECT_NEAR((above - below) / (2 * h), gradient[i], 1e-7 * std::sqrt(cost * curvature[i]))
            << i << " " << radius;
        ++num_checked;
      }
      params[0] += 1;
      params[3] -= 2;
      *bundle.path() += 0.1;
    }
  }
  EXPECT_EQ(num_checked, 4 * 2 * (kNumParams<M> + 1));
}

// Where both end, as the root mean square of a corner and in standard deviations of the parameters.
template <class M>
void expectOptimumOfPlainCeres(double outlier_px) {
  constexpr double kTight = 1e-18;  // by default, the last step may be one of a millionth of a sigma
  BundleSet<M> set(12, outlier_px);
  auto poses = blocksOf(set.state.camera_from_board);
  std::vector<double> params = set.state.params;
  ceres::Problem plain;
  addCorners<M>(plain, set.views, new ceres::HuberLoss(kLoss.threshold_px), params, poses);
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

  const BundleSummary summary =
      solveBundle(M::kId, set.views, set.state, {.loss = kLoss, .function_tolerance = kTight});
  ASSERT_EQ(summary.termination, Termination::kConverged) << summary.reason;
  // The RMS goes with the root of the cost.
  constexpr double kRelativeRms = 1e-8;
  EXPECT_NEAR(std::sqrt(summary.cost / plain_summary.final_cost), 1.0, kRelativeRms);

  const auto inverse = intrinsicsInformation(M::kId, set.views, set.state).inverse;
  ASSERT_TRUE(inverse);
  constexpr double kNoisePx = 0.2;
  // Both stop where the cost has no more digits, which is worth its root in sigmas; coefficients of a
  // numerator and a denominator make up for each other besides.
  constexpr bool kIsValley = kNumParams < M >> 9;
  constexpr double kSigmas = kIsValley ? 2e-5 : 2e-6;
  for (std::size_t i = 0; i < params.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double sigma = kNoisePx * std::sqrt((*inverse)(k, k));
    EXPECT_NEAR(set.state.params[i], params[i], kSigmas * sigma) << kParamNames<M>[i];
  }
  const AnyCamera camera = AnyCamera::make(M::kId, set.state.params);
  const AnyCamera plain_camera = AnyCamera::make(M::kId, params);
  double largest_px = 0;
  int num_checked = 0;
  for (double angle = 0; angle < 0.6; angle += 0.05) {
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d ray = rayAt(angle, k * std::numbers::pi / 4);
      largest_px = std::max(largest_px, (camera.project(ray).pixel - plain_camera.project(ray).pixel).norm());
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 12 * 8);
  EXPECT_LE(largest_px, kIsValley ? 1e-5 : 1e-6);
}

TYPED_TEST(BundleOf, ReachesTheOptimumOfPlainCeres) {
  expectOptimumOfPlainCeres<TypeParam>(0);
}

TYPED_TEST(BundleOf, ReachesTheOptimumOfPlainCeresDespiteOutliers) {
  expectOptimumOfPlainCeres<TypeParam>(kOutlierPx);
}

TYPED_TEST(BundleOf, GivesTheSameBytesAgain) {
  using M = TypeParam;
  const BundleSet<M> set(6, kOutlierPx);
  BundleState first = set.state;
  BundleState second = set.state;
  const double cost = solveBundle(M::kId, set.views, first, {.loss = kLoss}).cost;
  EXPECT_EQ(solveBundle(M::kId, set.views, second, {.loss = kLoss}).cost, cost);
  EXPECT_EQ(first.params, second.params);
  ASSERT_EQ(first.camera_from_board.size(), 6U);
  for (std::size_t v = 0; v < 6; ++v)
    EXPECT_EQ(toBlock(first.camera_from_board[v]), toBlock(second.camera_from_board[v]));
}

TEST(SolveBundle, FailsFromBehindTheCamera) {
  BundleSet<Radtan> set(4, 0);
  set.state.camera_from_board[2].translation.z() = -1;
  testing::internal::CaptureStderr();
  const BundleSummary summary = solveBundle("radtan", set.views, set.state, {.loss = kLoss});
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(summary.termination, Termination::kFailed);
  EXPECT_TRUE(std::isnan(summary.cost));
}

// Where parameters make up for each other, no factorization may fail aloud.
TEST(SolveBundle, SaysNothingOnStandardErrorAboutValleys) {
  int num_solved = 0;
  for (const int num_views : {1, 2, 3}) {
    BundleSet<Rational> set(num_views, kOutlierPx);
    testing::internal::CaptureStderr();
    const BundleSummary summary = solveBundle("rational", set.views, set.state, {.loss = kLoss});
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << num_views;
    EXPECT_NE(summary.termination, Termination::kFailed) << summary.reason;
    ++num_solved;
  }
  EXPECT_EQ(num_solved, 3);
}

// With nothing left of the parameters the views have nothing to do with each other.
TEST(SolveBundle, SolvesPosesAloneWhereAllParametersAreHeld) {
  BundleSet<Radtan> set(4, 0);
  const std::vector<double> params = set.state.params;
  const ParamConstraint all_held{.held = {0, 1, 2, 3, 4, 5, 6, 7, 8}};
  BundleState alone = set.state;
  double sum = 0;
  for (std::size_t v = 0; v < 4; ++v) {
    BundleState one{.params = params, .camera_from_board = {set.state.camera_from_board[v]}};
    sum +=
        solveBundle("radtan", std::span(&set.views[v], 1), one, {.loss = kLoss, .constraint = all_held}).cost;
    alone.camera_from_board[v] = one.camera_from_board[0];
  }
  const BundleSummary summary =
      solveBundle("radtan", set.views, set.state, {.loss = kLoss, .constraint = all_held});
  EXPECT_EQ(summary.termination, Termination::kConverged) << summary.reason;
  EXPECT_NEAR(summary.cost, sum, 1e-9 * sum);
  EXPECT_EQ(set.state.params, params);
  for (std::size_t v = 0; v < 4; ++v) {
    const SE3 difference = alone.camera_from_board[v].inverse() * set.state.camera_from_board[v];
    EXPECT_LE(difference.log().norm(), 1e-6) << v;
  }
  double errors = 0;
  for (std::size_t v = 0; v < 4; ++v) {
    const auto of_view = reprojectionErrors("radtan", params, set.state.camera_from_board[v], set.views[v]);
    for (std::size_t i = 0; i < of_view.size(); ++i)
      errors += 0.5 * kLoss.rho(set.views[v][i].weight * of_view[i].squaredNorm());
  }
  EXPECT_NEAR(errors, summary.cost, 1e-9 * errors);
}

TEST(SolveBundle, ReportsTheIterationLimit) {
  BundleSet<Radtan> set(4, 0);
  const BundleSummary summary =
      solveBundle("radtan", set.views, set.state, {.loss = kLoss, .max_iterations = 2});
  EXPECT_EQ(summary.termination, Termination::kIterationLimit);
  EXPECT_EQ(summary.num_iterations, 2);
}

}  // namespace
}  // namespace alidade
