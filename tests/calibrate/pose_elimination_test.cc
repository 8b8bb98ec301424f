// SPDX-License-Identifier: MIT
#include "alidade/calibrate/pose_elimination.h"

#include <gtest/gtest.h>

#include <vector>

#include <Eigen/Cholesky>

#include "alidade/core/random.h"
#include "support/loop_variants.h"

namespace alidade {
namespace {

constexpr std::size_t kNumViews = 5;

// Normal equations of views, each by itself, of rows without any pattern.
struct Views {
  Views(int num_params, int num_rows) : columns(6 + num_params + 1) {
    Random random(3);
    shared = Eigen::MatrixXd::Zero(num_params + 1, num_params + 1);
    const std::size_t stride = PoseRowLayout::stride(num_params);
    rows.resize(kNumViews * PoseRowLayout::size(num_params));
    for (std::size_t v = 0; v < kNumViews; ++v) {
      Eigen::MatrixXd J(num_rows, columns);
      for (Eigen::Index i = 0; i < J.size(); ++i) J.data()[i] = random.uniform(-1, 1);
      if (v == 1) J.setZero();  // a view of which nothing is seen
      grams.emplace_back(J.transpose() * J);
      shared += grams.back().bottomRightCorner(num_params + 1, num_params + 1);
      for (Eigen::Index i = 0; i < 6; ++i) {
        double* row = rows.data() + (v * 6 + static_cast<std::size_t>(i)) * stride;
        for (Eigen::Index j = 0; j < columns; ++j)
          row[j < 6 ? static_cast<std::size_t>(j)
                    : PoseRowLayout::kShared + static_cast<std::size_t>(j) - 6] = grams.back()(i, j);
      }
      poses.push_back(SE3::exp(SE3::Vec6::Constant(0.1 * static_cast<double>(v))));
    }
  }

  // Of a view's pose, by the columns of parameters and error.
  [[nodiscard]] Eigen::MatrixXd solved(std::size_t v, double damping) const {
    Eigen::MatrixXd A = grams[v].topLeftCorner<6, 6>();
    A.diagonal() += damping * A.diagonal().cwiseMax(1e-6);
    return A.ldlt().solve(grams[v].topRightCorner(6, columns - 6));
  }

  int columns;
  std::vector<Eigen::MatrixXd> grams;
  Eigen::MatrixXd shared;
  std::vector<double> rows;
  std::vector<SE3> poses;
};

TEST(PoseElimination, LeavesWhatDenseAlgebraLeavesAndStepsAsItDoes) {
  int num_checked = 0;
  for (const int num_params : {4, 5, 6, 8, 9, 12, 16}) {
    const Views views(num_params, 40);
    const PoseElimination& elimination = poseElimination(num_params);
    for (const double damping : {kMinDamping, 1e-4, 1.0, 1e3}) {
      withAndWithoutAvx2([&] {
        Eigen::MatrixXd schur = views.shared;
        std::vector<double> factors(views.rows.size());
        elimination.eliminate(views.rows, damping, factors, schur);
        Eigen::MatrixXd expected = views.shared;
        for (std::size_t v = 0; v < kNumViews; ++v) {
          const auto coupling = views.grams[v].topRightCorner(6, num_params + 1);
          expected -= coupling.transpose() * views.solved(v, damping);
        }
        const Eigen::MatrixXd difference = schur - expected;
        EXPECT_LE(difference.triangularView<Eigen::Lower>().toDenseMatrix().cwiseAbs().maxCoeff(), 1e-11);

        const double share = 0.3;
        Eigen::VectorXd step = Eigen::VectorXd::LinSpaced(num_params + 1, -0.02, 0.05);
        step(num_params) = share;
        std::vector<SE3> moved(kNumViews);
        elimination.step(factors, share, {step.data(), static_cast<std::size_t>(num_params)}, views.poses,
                         moved);
        for (std::size_t v = 0; v < kNumViews; ++v) {
          const SE3::Vec6 xi = (views.poses[v].inverse() * moved[v]).log();
          EXPECT_LE((xi + views.solved(v, damping) * step).norm(), 1e-10) << v;
          ++num_checked;
        }
      });
    }
  }
  EXPECT_EQ(num_checked, 7 * 4 * 2 * static_cast<int>(kNumViews));
}

// Two rows leave four of six directions of each pose open.
TEST(PoseElimination, StaysFiniteWhereThePosesAreNotDetermined) {
  const Views views(9, 2);
  std::vector<double> factors(views.rows.size());
  Eigen::MatrixXd schur = views.shared;
  poseElimination(9).eliminate(views.rows, kMinDamping, factors, schur);
  EXPECT_TRUE(schur.allFinite());
  std::vector<SE3> moved(kNumViews);
  poseElimination(9).step(factors, 1, std::vector<double>(9), views.poses, moved);
  for (const SE3& pose : moved) EXPECT_TRUE(pose.matrix().allFinite());
}

}  // namespace
}  // namespace alidade
