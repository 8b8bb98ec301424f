// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/view_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/bundle_set.h"
#include "support/loop_variants.h"
#include "support/reprojection.h"

namespace alidade {
namespace {

constexpr HuberLoss kLoss{.threshold_px = 1.5};
// Corners in one group, in one chunk and in several of them, filled up and not.
const Checkerboard kBoards[] = {{.columns = 4, .rows = 1, .square_m = 0.025},
                                {.columns = 9, .rows = 6, .square_m = 0.025},
                                {.columns = 19, .rows = 15, .square_m = 0.012}};

// A view's normal equations, corner by corner; those that cannot be projected are left out.
template <class M>
Eigen::MatrixXd plainGram(const double* params, const SE3& pose, const std::vector<Observation>& view,
                          HuberLoss loss) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(kNumParams<M> + 7, kNumParams<M> + 7);
  double sum_rho = 0;
  Reprojection<M> corner;
  for (const Observation& observation : view) {
    if (!reproject<M>(params, pose.rotation.matrix(), pose.translation, observation.p_board, corner))
      continue;
    const Eigen::Vector2d error = corner.pixel - observation.pixel;
    const double s = observation.weight * error.squaredNorm();
    Eigen::MatrixXd rows(2, kNumParams<M> + 7);  // a fixed size would be compiled for each model
    rows << corner.J_px_pose, corner.J_px_params, error;
    gram += observation.weight * loss.weight(s) * rows.transpose() * rows;
    sum_rho += loss.rho(s);
  }
  gram(kNumParams<M> + 6, kNumParams<M> + 6) = sum_rho;
  return gram;
}

// What the factor makes up.
Eigen::MatrixXd gramOf(const ViewFactor& factor) {
  return factor.transpose() * factor;
}

void expectEqual(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected) {
  ASSERT_EQ(actual.rows(), expected.rows());
  ASSERT_EQ(actual.cols(), expected.cols());
  for (int i = 0; i < expected.rows(); ++i) {
    for (int j = 0; j < expected.cols(); ++j) {
      const double scale = std::sqrt(expected(i, i) * expected(j, j));
      ASSERT_NEAR(actual(i, j), expected(i, j), 1e-11 * scale) << i << "," << j;
    }
  }
}

template <class M>
class ViewKernelOf : public testing::Test {};
TYPED_TEST_SUITE(ViewKernelOf, AllModelTypes, ModelName);

TYPED_TEST(ViewKernelOf, SumsWhatCornersGiveOneByOne) {
  using M = TypeParam;
  const ViewKernel& kernel = viewKernel(M::kId, kNumParams<M>);
  ASSERT_EQ(kernel.numParams(), kNumParams<M>);
  int num_checked = 0;
  int num_far = 0;
  for (const Checkerboard& board : kBoards) {
    const Fit fit = bundleSet<M>(3, 15.0, kNoLoss, board);
    const double* params = fit.cameras.front().params.data();
    for (const FitView& view : fit.views) {
      const SE3 pose = cameraFromBoard(fit, view);
      const auto corners = groupsOf(view.corners);
      const Eigen::MatrixXd expected = plainGram<M>(params, pose, view.corners, kLoss);
      withAndWithoutAvx2([&] {
        const auto factor =
            viewFactor(kernel, fit.cameras.front().params, pose, corners, kLoss, Unseen::kRefuse);
        ASSERT_TRUE(factor);
        expectEqual(gramOf(*factor), expected);
        // Rows of the pose first, then of the parameters, then of the error.
        EXPECT_EQ(factor->bottomLeftCorner(kNumParams<M> + 1, 6).norm(), 0);
        EXPECT_EQ(factor->bottomLeftCorner(1, kNumParams<M> + 6).norm(), 0);
        const double sum_rho = expected(kNumParams<M> + 6, kNumParams<M> + 6);
        EXPECT_NEAR(kernel.sumOfRho(params, pose, corners, kLoss), sum_rho, 1e-12 * sum_rho);
        std::vector<Eigen::Vector2d> errors(view.corners.size());
        kernel.errors(params, pose, corners, errors);
        for (std::size_t i = 0; i < errors.size(); ++i) {
          Reprojection<M> corner;
          const Observation& observation = view.corners[i];
          ASSERT_TRUE(
              reproject<M>(params, pose.rotation.matrix(), pose.translation, observation.p_board, corner));
          EXPECT_LE((errors[i] - (corner.pixel - observation.pixel)).norm(), 1e-9);
          num_far += kLoss.weight(observation.weight * errors[i].squaredNorm()) < 1;
        }
        ++num_checked;
      });
    }
  }
  EXPECT_EQ(num_checked, 3 * 3 * 2);
  EXPECT_GT(num_far, 0);
}

// A lens that sees behind itself takes such a pose exactly if it sees all corners there.
TYPED_TEST(ViewKernelOf, RefusesCornersBehindTheCamera) {
  using M = TypeParam;
  const Fit fit = bundleSet<M>(1, 0);
  const std::vector<Observation>& view = fit.views[0].corners;
  const std::vector<double>& params = fit.cameras.front().params;
  SE3 pose = cameraFromBoard(fit, fit.views[0]);
  pose.translation.z() = -1;
  const AnyCamera camera = AnyCamera::make(M::kId, params);
  const bool sees_all = std::all_of(
      view.begin(), view.end(), [&](const Observation& o) { return camera.project(pose * o.p_board).ok(); });
  if (M::kMaxAngle <= std::numbers::pi / 2) {
    EXPECT_FALSE(sees_all);
  }
  const auto corners = groupsOf(view);
  const ViewKernel& kernel = viewKernel(M::kId, kNumParams<M>);
  withAndWithoutAvx2([&] {
    EXPECT_EQ(viewFactor(kernel, params, pose, corners, kLoss, Unseen::kRefuse).has_value(), sees_all);
    EXPECT_EQ(std::isfinite(kernel.sumOfRho(params.data(), pose, corners, kLoss)), sees_all);
  });
}

// A board that the camera stands in the middle of, so that a part of it is in front.
TEST(ViewKernel, LeavesOutTheCornersThatCannotBeProjected) {
  const Fit fit = bundleSet<Radtan>(1, 0);
  const std::vector<Observation>& view = fit.views[0].corners;
  const double* params = fit.cameras.front().params.data();
  SE3 pose;
  pose.rotation = SO3::exp({0, 1.2, 0});
  pose.translation = {-0.05, -0.05, 0.1};
  const auto corners = groupsOf(view);
  const ViewKernel& kernel = viewKernel("radtan", kNumParams<Radtan>);
  std::size_t num_seen = 0;
  Reprojection<Radtan> corner;
  for (const Observation& o : view)
    num_seen += reproject<Radtan>(params, pose.rotation.matrix(), pose.translation, o.p_board, corner);
  ASSERT_GT(num_seen, 10U);
  ASSERT_LT(num_seen, view.size());
  withAndWithoutAvx2([&] {
    const auto all = [&](Unseen unseen) {
      return viewFactor(kernel, fit.cameras.front().params, pose, corners, kNoLoss, unseen);
    };
    EXPECT_FALSE(all(Unseen::kRefuse));
    ASSERT_TRUE(all(Unseen::kLeaveOut));
    expectEqual(gramOf(*all(Unseen::kLeaveOut)), plainGram<Radtan>(params, pose, view, kNoLoss));
    std::vector<Eigen::Vector2d> errors(view.size());
    kernel.errors(params, pose, corners, errors);
    const auto num_finite =
        std::count_if(errors.begin(), errors.end(), [](const auto& e) { return e.allFinite(); });
    EXPECT_EQ(static_cast<std::size_t>(num_finite), num_seen);
  });
}

TEST(ViewKernel, RefusesAFoldedLens) {
  Fit fit = bundleSet<Radtan>(1, 0);
  std::vector<double>& params = fit.cameras.front().params;
  const auto corners = groupsOf(fit.views[0].corners);
  const SE3 pose = cameraFromBoard(fit, fit.views[0]);
  const ViewKernel& kernel = viewKernel("radtan", kNumParams<Radtan>);
  EXPECT_TRUE(viewFactor(kernel, params, pose, corners, kLoss, Unseen::kRefuse));
  params[4] = -30;  // folds at six degrees from the axis
  EXPECT_FALSE(viewFactor(kernel, params, pose, corners, kLoss, Unseen::kRefuse));
}

// Columns that the others determine leave rows that must not blow up.
TEST(ViewKernel, FactorsWhatOneFlatViewTells) {
  const Fit fit = bundleSet<Rational>(1, 0);
  const auto corners = groupsOf(fit.views[0].corners);
  constexpr int kSize = kNumParams<Rational> + 7;
  const double* params = fit.cameras.front().params.data();
  const SE3 pose = cameraFromBoard(fit, fit.views[0]);
  const auto factor = viewFactor(viewKernel("rational", kNumParams<Rational>), fit.cameras.front().params,
                                 pose, corners, kLoss, Unseen::kRefuse);
  ASSERT_TRUE(factor);
  const Eigen::MatrixXd again = gramOf(*factor);
  ASSERT_TRUE(again.allFinite());
  ASSERT_EQ(again.cols(), kSize);
  const Eigen::MatrixXd expected = plainGram<Rational>(params, pose, fit.views[0].corners, kLoss);
  int num_checked = 0;
  for (int j = 0; j < kSize; ++j) {
    const double scale = std::sqrt(expected(j, j) * expected(kSize - 1, kSize - 1));
    EXPECT_NEAR(again(j, kSize - 1), expected(j, kSize - 1), 1e-10 * scale);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kSize);
}

// The rows of a camera with an entrance pupil that moves, against errors beside it.
TYPED_TEST(ViewKernelOf, DerivesByTheEntrancePupil) {
  using M = TypeParam;
  constexpr double kStep = 1e-6;  // metres, and of the tangent
  int num_checked = 0;
  for (const std::size_t num_pupil : {1U, 2U}) {
    const ViewKernel& kernel = viewKernel(M::kId, kNumParams<M> + num_pupil);
    ASSERT_EQ(kernel.numParams(), kNumParams<M> + static_cast<int>(num_pupil));
    const Fit fit = bundleSet<M>(2, 0.0);
    std::vector<double> params = fit.cameras.front().params;
    params.insert(params.end(), {0.003, -0.002});
    const FitView& view = fit.views.front();
    const SE3 pose = cameraFromBoard(fit, view);
    const auto corners = groupsOf(view.corners);
    const auto width = static_cast<std::size_t>(kernel.numParams() + 7);
    const auto errorsAt = [&](const std::vector<double>& at, const SE3& from) {
      std::vector<Eigen::Vector2d> errors(view.corners.size());
      kernel.errors(at.data(), from, corners, errors);
      return errors;
    };
    withAndWithoutAvx2([&] {
      std::vector<double> rows(2 * width * view.corners.size());
      kernel.rows(params.data(), pose, corners, rows);
      for (std::size_t column = 0; column < 6 + static_cast<std::size_t>(kernel.numParams()); ++column) {
        if (column >= 6 && column < 6 + kNumParams<M>) continue;  // as without a pupil
        const auto beside = [&](double step) {
          if (column < 6)
            return errorsAt(params,
                            pose * SE3::exp(step * SE3::Tangent::Unit(static_cast<Eigen::Index>(column))));
          std::vector<double> at = params;
          at[column - 6] += step;
          return errorsAt(at, pose);
        };
        const auto above = beside(kStep);
        const auto below = beside(-kStep);
        for (std::size_t i = 0; i < view.corners.size(); ++i) {
          const Eigen::Vector2d slope =
              std::sqrt(view.corners[i].weight) * (above[i] - below[i]) / (2 * kStep);
          const Eigen::Vector2d found(rows[2 * i * width + column], rows[(2 * i + 1) * width + column]);
          ASSERT_NEAR((found - slope).norm(), 0, 1e-6 * (1 + slope.norm())) << column << " " << i;
          ++num_checked;
        }
      }
    });
  }
  EXPECT_EQ(num_checked, 2 * (7 + 8) * 54);
}

}  // namespace
}  // namespace alidade
