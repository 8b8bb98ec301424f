// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/reduced.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "support/bundle_set.h"
#include "support/model_fixture.h"
#include "support/reprojection.h"

namespace alidade {
namespace {

constexpr HuberLoss kLoss{.threshold_px = 1.5};
constexpr double kOutlierPx = 15;

// Two made-up columns: one in rows of u alone, one in both.
struct MadeUpColumns {
  static int size() { return 2; }
  static ExtraElements<2> elements(const CornerRows& rows, int axis) {
    const double first = axis == 0 ? rows.root_weight * rows.corner.p_board.x() : 0.0;
    return {.column = {0, 1}, .value = {first, rows.J_px_pose[static_cast<std::size_t>(axis)][1]}};
  }
};

// The same from corner after corner and by a general inverse. `scale`: units of the columns before the pose
// is eliminated, which takes nearly all of some of them.
template <class M>
Reduced denseReduced(const double* params, const SE3& pose, std::span<const Observation> view,
                     LossWeights weights, Eigen::VectorXd& scale) {
  const Eigen::Index num_global = kNumParams<M> + 2;  // sizes that differ by model would be compiled for each
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(6 + num_global, 6 + num_global);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(6 + num_global);
  double squares = 0;
  Reprojection<M> corner;
  Reduced result;
  for (const Observation& o : view) {
    if (!reproject<M>(params, pose.rotation.matrix(), pose.translation, o.p_board, corner)) continue;
    Eigen::MatrixXd J(2, 6 + num_global);
    J << corner.J_px_pose, corner.J_px_params, Eigen::Vector2d(o.p_board.x(), 0), corner.J_px_pose.col(1);
    const Eigen::Vector2d error = corner.pixel - o.pixel;
    const double robust = kLoss.weight(o.weight * error.squaredNorm());
    H += o.weight * (weights == LossWeights::kUse ? robust : 1.0) * J.transpose() * J;
    g += o.weight * robust * J.transpose() * error;
    squares += o.weight * robust * error.squaredNorm();
    ++result.num_corners;
  }
  const Eigen::MatrixXd back = H.bottomLeftCorner(num_global, 6) * H.topLeftCorner<6, 6>().inverse();
  result.information = H.bottomRightCorner(num_global, num_global) - back * H.topRightCorner(6, num_global);
  result.gradient = g.tail(num_global) - back * g.head<6>();
  scale = H.diagonal().tail(num_global).cwiseSqrt().cwiseInverse();
  result.squares = squares - g.head<6>().dot(H.topLeftCorner<6, 6>().inverse() * g.head<6>());
  return result;
}

template <class M>
class ReducedOf : public testing::Test {};
TYPED_TEST_SUITE(ReducedOf, AllModelTypes, ModelName);

TYPED_TEST(ReducedOf, IsTheSchurComplementOfThePose) {
  using M = TypeParam;
  const Fit fit = bundleSet<M>(4, kOutlierPx, kLoss);
  int num_checked = 0;
  for (const LossWeights weights : {LossWeights::kLeaveOut, LossWeights::kUse}) {
    const auto all = reduced(fit, weights, MadeUpColumns{});
    ASSERT_EQ(all.size(), fit.views.size());
    for (std::size_t v = 0; v < all.size(); ++v) {
      Eigen::VectorXd scale;
      const Reduced dense =
          denseReduced<M>(fit.cameras.front().params.data(), cameraFromBoard(fit, fit.views[v]),
                          fit.views[v].corners, weights, scale);
      EXPECT_EQ(all[v].num_corners, dense.num_corners);
      constexpr double kRounding = 1e-9;
      const Eigen::MatrixXd difference = all[v].information - dense.information;
      EXPECT_LE((scale.asDiagonal() * difference * scale.asDiagonal()).cwiseAbs().maxCoeff(), kRounding);
      EXPECT_LE(scale.cwiseProduct(all[v].gradient - dense.gradient).norm(),
                kRounding * std::sqrt(dense.squares));
      if (weights == LossWeights::kUse) {
        EXPECT_NEAR(all[v].squares, dense.squares, kRounding * dense.squares);
      }
      EXPECT_EQ(all[v].information, all[v].information.transpose());
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 8);
}

TEST(Reduced, LeavesOutCornersThatDoNotProject) {
  Fit fit = bundleSet<Radtan>(1, 0, kLoss);
  std::vector<Observation>& corners = fit.views[0].corners;
  corners[3].p_board.z() = -10;  // behind the camera
  const Reduced with = reduced(fit, LossWeights::kUse)[0];
  corners.erase(corners.begin() + 3);
  const Reduced without = reduced(fit, LossWeights::kUse)[0];
  EXPECT_EQ(with.num_corners, without.num_corners);
  EXPECT_LE((with.information - without.information).norm(), 1e-9 * without.information.norm());
  EXPECT_LE((with.gradient - without.gradient).norm(), 1e-9 * without.information.norm());
}

// The bend of a flexible board is one more unknown of the view, with a prior.
TEST(Reduced, EliminatesTheBendOfAFlexibleBoard) {
  Fit fit = bundleSet<Radtan>(4, kOutlierPx, kLoss);
  FitBoard& board = fit.boards.front();
  board.flex.std_m = 1e-3;
  board.flex.precision = 1e4;
  int num_checked = 0;
  for (FitView& view : fit.views) {
    view.flex_m = {2e-3, -1e-3};
    const Reduced flexible = reduced(fit, view, LossWeights::kUse, MadeUpColumns{});
    board.flex.std_m = 0;
    const Reduced rigid = reduced(fit, view, LossWeights::kUse, MadeUpColumns{});
    board.flex.std_m = 1e-3;
    const Reduced all = reducedByPose(fit, view, LossWeights::kUse, bendColumns(&board.target));
    const Eigen::Index n = all.gradient.size() - kNumBends;
    Eigen::MatrixXd H = all.information;
    Eigen::VectorXd g = all.gradient;
    H.bottomRightCorner<kNumBends, kNumBends>().diagonal().array() += board.flex.precision;
    g.tail<kNumBends>() += board.flex.precision * view.flex_m;
    const Eigen::MatrixXd back =
        H.topRightCorner(n, kNumBends) * H.bottomRightCorner<kNumBends, kNumBends>().inverse();
    const Eigen::MatrixXd information = H.topLeftCorner(n, n) - back * H.bottomLeftCorner(kNumBends, n);
    const Eigen::VectorXd gradient = g.head(n) - back * g.tail<kNumBends>();
    EXPECT_LE((flexible.information.topLeftCorner(n, n) - information).norm(), 1e-9 * information.norm());
    EXPECT_LE((flexible.gradient.head(n) - gradient).norm(), 1e-9 * gradient.norm());
    // Bends take information away, in the further columns as well.
    EXPECT_GT(rigid.information.trace(), flexible.information.trace());
    EXPECT_GT(rigid.information(n, n), flexible.information(n, n));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 4);
}

}  // namespace
}  // namespace alidade
