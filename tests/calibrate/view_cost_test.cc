// SPDX-License-Identifier: MIT
#include "alidade/calibrate/view_cost.h"

#include <gtest/gtest.h>

#include <ceres/ceres.h>

#include <algorithm>
#include <numbers>

#include "support/model_fixture.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

// One corner, differentiated automatically, under Ceres' own loss: the plainest form of the same problem.
template <class M>
struct CornerCost {
  Observation observation;

  template <class T>
  bool operator()(const T* params, const T* pose, T* residual) const {
    const Eigen::Quaternion<T> q(pose[3], pose[0], pose[1], pose[2]);
    const Eigen::Matrix<T, 3, 1> t(pose[4], pose[5], pose[6]);
    const Eigen::Matrix<T, 3, 1> p = q * observation.p_board.cast<T>() + t;
    T px[2];
    if (!projectFormula<M>(params, p.data(), px)) return false;
    const double root = std::sqrt(observation.weight);
    residual[0] = root * (px[0] - observation.pixel.x());
    residual[1] = root * (px[1] - observation.pixel.y());
    return true;
  }
};

// Corners with noise and all kinds of weights, every ninth of them far off, and a start beside the truth.
template <class M>
struct Problem {
  std::vector<std::vector<Observation>> views;
  std::vector<double> params;
  std::vector<PoseBlock> poses;

  explicit Problem(int num_views) {
    const auto p = ModelFixture<M>::paramSets().front();
    const SimulatedSet set = simulateSet(AnyCamera(Camera<M>(p)), kTestImage, num_views, 0.2, 5);
    Random random(6);
    for (std::size_t v = 0; v < set.views.size(); ++v) {
      views.emplace_back();
      for (const Corner& corner : set.views[v].corners) {
        const double off = corner.id % 9 == 4 ? 15.0 : 0.0;
        views.back().push_back({.p_board = set.board.corner(corner.id),
                                .pixel = corner.pixel + Eigen::Vector2d(off, -off),
                                .weight = random.uniform(0.2, 3.0)});
      }
      SE3 pose = set.poses[v];
      pose.translation.z() *= 1.03;
      poses.push_back(toBlock(pose));
    }
    params.assign(p.begin(), p.end());
    params[0] *= 1.02;
    params[2] += 3;
  }
};

constexpr double kThreshold = 1.5;

template <class M>
class ViewCostOf : public testing::Test {};
TYPED_TEST_SUITE(ViewCostOf, AllModelTypes, ModelName);

// Builds both forms of the problem over the same parameter blocks.
template <class M>
void addViews(ceres::Problem& problem, Problem<M>& data) {
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    problem.AddResidualBlock(new ViewCost<M>(data.views[v], {.threshold_px = kThreshold}), nullptr,
                             data.params.data(), data.poses[v].data());
    problem.SetManifold(data.poses[v].data(), new SE3Manifold);
  }
}

template <class M>
void addCorners(ceres::Problem& problem, Problem<M>& data) {
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    for (const Observation& observation : data.views[v]) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<CornerCost<M>, 2, kNumParams<M>, 7>(new CornerCost<M>{observation}),
          new ceres::HuberLoss(kThreshold), data.params.data(), data.poses[v].data());
    }
    problem.SetManifold(data.poses[v].data(), new SE3Manifold);
  }
}

TYPED_TEST(ViewCostOf, CostAndGradientEqualThoseOfCornersUnderCeresLoss) {
  using M = TypeParam;
  Problem<M> data(5);
  ceres::Problem by_view;
  ceres::Problem by_corner;
  addViews(by_view, data);
  addCorners(by_corner, data);
  double cost_view = 0;
  double cost_corner = 0;
  std::vector<double> gradient_view;
  std::vector<double> gradient_corner;
  ASSERT_TRUE(by_view.Evaluate({}, &cost_view, nullptr, &gradient_view, nullptr));
  ASSERT_TRUE(by_corner.Evaluate({}, &cost_corner, nullptr, &gradient_corner, nullptr));
  EXPECT_NEAR(cost_view, cost_corner, 1e-12 * cost_corner);
  ASSERT_EQ(gradient_view.size(), gradient_corner.size());
  ASSERT_EQ(gradient_view.size(), static_cast<std::size_t>(kNumParams<M> + 5 * 6));
  for (std::size_t i = 0; i < gradient_view.size(); ++i) {
    EXPECT_NEAR(gradient_view[i], gradient_corner[i], 1e-9 * (1 + std::abs(gradient_corner[i]))) << i;
  }
}

TYPED_TEST(ViewCostOf, ReachesTheOptimumOfPlainCeres) {
  using M = TypeParam;
  Problem<M> data(12);
  Problem<M> same = data;
  const auto solve = [](ceres::Problem& problem) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-15;
    options.parameter_tolerance = 1e-13;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    EXPECT_EQ(summary.termination_type, ceres::CONVERGENCE) << summary.message;
    return summary.final_cost;
  };
  ceres::Problem by_view;
  ceres::Problem by_corner;
  addViews(by_view, data);
  addCorners(by_corner, same);
  const double cost_view = solve(by_view);
  const double cost_corner = solve(by_corner);
  EXPECT_NEAR(cost_view, cost_corner, 1e-9 * cost_corner);
  // Coefficients of a numerator and a denominator make up for each other: there the pictures must agree.
  const double tolerance = kNumParams<M> > 9 ? 1e-4 : 1e-6;
  for (std::size_t i = 0; i < data.params.size(); ++i) {
    EXPECT_NEAR(data.params[i], same.params[i], tolerance * (1 + std::abs(same.params[i])))
        << kParamNames<M>[i];
  }
  const AnyCamera camera = AnyCamera::make(M::kId, data.params);
  const AnyCamera same_camera = AnyCamera::make(M::kId, same.params);
  int num_checked = 0;
  for (double angle = 0; angle < 0.6; angle += 0.05) {
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d ray = rayAt(angle, k * std::numbers::pi / 4);
      EXPECT_LE((camera.project(ray).pixel - same_camera.project(ray).pixel).norm(), 1e-4);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 12 * 8);
}

// A lens that sees behind itself takes such a step exactly if it sees all corners there.
TYPED_TEST(ViewCostOf, RefusesAStepThatPutsACornerBehindTheCamera) {
  using M = TypeParam;
  Problem<M> data(1);
  data.poses[0][6] = -1.0;
  const AnyCamera camera = AnyCamera::make(M::kId, data.params);
  const SE3 pose = fromBlock(data.poses[0].data());
  const bool sees_all = std::all_of(data.views[0].begin(), data.views[0].end(), [&](const Observation& o) {
    return camera.project(pose * o.p_board).ok();
  });
  if (M::kMaxAngle <= std::numbers::pi / 2) {
    EXPECT_FALSE(sees_all);
  }
  const ViewCost<M> cost(data.views[0], {.threshold_px = kThreshold});
  std::vector<double> residuals(static_cast<std::size_t>(cost.num_residuals()));
  const double* blocks[] = {data.params.data(), data.poses[0].data()};
  EXPECT_EQ(cost.Evaluate(blocks, residuals.data(), nullptr), sees_all);
}

// Columns of very different scales that depend on each other, as those of one flat view do: pivots there are
// rounding, and must neither blow up nor cost the gradient its digits.
TEST(Factorize, KeepsTheGradientWherePivotsAreRounding) {
  constexpr int kSize = 12;
  using Gram = Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>;
  Random random(3);
  int num_checked = 0;
  for (int set = 0; set < 2000; ++set) {
    Eigen::Matrix<double, 60, kSize> J;
    for (int i = 0; i < J.rows(); ++i) {
      for (int j = 0; j < kSize; ++j) J(i, j) = random.normal();
    }
    // All but four columns and the last are combinations of the four.
    for (int j = 4; j + 1 < kSize; ++j) {
      J.col(j).setZero();
      for (int k = 0; k < 4; ++k) J.col(j) += random.normal() * J.col(k);
    }
    for (int j = 0; j + 1 < kSize; ++j) J.col(j) *= std::pow(10.0, random.uniform(-4, 4));
    Gram gram = J.transpose() * J;
    const Gram before = gram;
    detail::factorize(gram);
    ASSERT_TRUE(gram.allFinite()) << "set " << set;
    const Gram again = gram.transpose() * gram;
    for (int j = 0; j + 1 < kSize; ++j) {
      const double scale = std::sqrt(before(j, j) * before(kSize - 1, kSize - 1));
      ASSERT_NEAR(again(j, kSize - 1), before(j, kSize - 1), 1e-6 * scale) << "set " << set;
      ASSERT_NEAR(again(j, j), before(j, j), 1e-6 * before(j, j)) << "set " << set;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 2000 * (kSize - 1));
}

TEST(ViewCost, RefusesAFoldedLens) {
  Problem<Radtan> data(1);
  const ViewCost<Radtan> cost(data.views[0], {.threshold_px = kThreshold});
  std::vector<double> residuals(static_cast<std::size_t>(cost.num_residuals()));
  const double* blocks[] = {data.params.data(), data.poses[0].data()};
  EXPECT_TRUE(cost.Evaluate(blocks, residuals.data(), nullptr));
  data.params[4] = -30;  // folds at six degrees from the axis
  EXPECT_FALSE(cost.Evaluate(blocks, residuals.data(), nullptr));
}

}  // namespace
}  // namespace alidade
