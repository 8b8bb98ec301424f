// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "alidade/adjust/board/view_kernel.h"
#include "alidade/camera/camera_variant.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

const Board kBoard = CircleGrid{.columns = 5, .rows = 4, .spacing_m = 0.04, .diameter_m = 0.03};
constexpr HuberLoss kLoss{.threshold_px = 1};

struct DiscSet {
  std::vector<double> params;
  std::vector<SE3> poses;
  std::vector<std::vector<Observation>> views;  // where the discs are seen, moved by up to a few pixels
};

template <class M>
DiscSet discSet(double most_off_px) {
  const auto p = ModelFixture<M>::paramSets().front();
  const AnyCamera camera{Camera<M>(p)};
  Random random(7);
  DiscSet set{.params = {p.begin(), p.end()}, .poses = {}, .views = {}};
  for (const SE3& pose : randomViews(camera, kTestImage, kBoard, 4, random)) {
    const View view = exactView(camera, kTestImage, kBoard, pose, "");
    auto corners = observationsOf(kBoard, view);
    for (Observation& corner : corners) {
      corner.pixel.x() += random.uniform(-most_off_px, most_off_px);
      corner.weight = random.uniform(0.5, 2.0);
    }
    set.poses.push_back(pose);
    set.views.push_back(corners);
  }
  return set;
}

template <class M>
class DiscRowsOf : public testing::Test {};
TYPED_TEST_SUITE(DiscRowsOf, AllModelTypes, ModelName);

TYPED_TEST(DiscRowsOf, AreZeroWhereTheCentroidsAreSeen) {
  const DiscSet set = discSet<TypeParam>(0);
  const ViewKernel& kernel = viewKernel(TypeParam::kId, kNumParams<TypeParam>);
  std::size_t num_checked = 0;
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    std::vector<Eigen::Vector2d> errors(set.views[v].size());
    kernel.errors(set.params.data(), set.poses[v], groupsOf(set.views[v]), errors);
    for (const Eigen::Vector2d& error : errors) EXPECT_LT(error.norm(), 1e-5);
    num_checked += errors.size();
  }
  EXPECT_GT(num_checked, 40U);
}

TYPED_TEST(DiscRowsOf, HaveTheDerivativesOfTheErrors) {
  using M = TypeParam;
  const DiscSet set = discSet<M>(2);
  const ViewKernel& kernel = viewKernel(M::kId, kNumParams<M>);
  const int size = kernel.numParams() + 7;
  const auto& view = set.views.front();
  const auto corners = groupsOf(view);
  std::vector<double> rows(2 * view.size() * static_cast<std::size_t>(size));
  kernel.rows(set.params.data(), set.poses.front(), corners, rows);
  const auto errorsAt = [&](int column, double step) {
    SE3 pose = set.poses.front();
    std::vector<double> params = set.params;
    if (column < 6) {
      pose = pose * SE3::exp(step * SE3::Vec6::Unit(column));
    } else {
      params[static_cast<std::size_t>(column - 6)] += step;
    }
    std::vector<Eigen::Vector2d> errors(view.size());
    kernel.errors(params.data(), pose, corners, errors);
    return errors;
  };
  int num_checked = 0;
  for (int column = 0; column < size - 1; ++column) {
    const double step = column < 6 ? 2e-5 : 2e-5 * std::max(1.0, std::abs(set.params[column - 6]));
    // Richardson's extrapolation of two central differences.
    const auto plus = errorsAt(column, step);
    const auto minus = errorsAt(column, -step);
    const auto half_plus = errorsAt(column, 0.5 * step);
    const auto half_minus = errorsAt(column, -0.5 * step);
    for (std::size_t i = 0; i < view.size(); ++i) {
      const Eigen::Vector2d wide = (plus[i] - minus[i]) / (2 * step);
      const Eigen::Vector2d narrow = (half_plus[i] - half_minus[i]) / step;
      const Eigen::Vector2d slope = std::sqrt(view[i].weight) * (4 * narrow - wide) / 3;
      for (int axis = 0; axis < 2; ++axis) {
        const double actual = rows[(2 * i + static_cast<std::size_t>(axis)) * static_cast<std::size_t>(size) +
                                   static_cast<std::size_t>(column)];
        EXPECT_NEAR(actual, slope(axis), 1e-6 * (1 + std::abs(actual))) << column;
        ++num_checked;
      }
    }
  }
  EXPECT_GT(num_checked, 200);
}

TYPED_TEST(DiscRowsOf, MakeUpFactorAndCost) {
  using M = TypeParam;
  const DiscSet set = discSet<M>(2);
  const ViewKernel& kernel = viewKernel(M::kId, kNumParams<M>);
  const int size = kernel.numParams() + 7;
  int num_far = 0;
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    const auto& view = set.views[v];
    const auto corners = groupsOf(view);
    std::vector<double> values(2 * view.size() * static_cast<std::size_t>(size));
    kernel.rows(set.params.data(), set.poses[v], corners, values);
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(size, size);
    double sum_of_rho = 0;
    for (std::size_t i = 0; i < view.size(); ++i) {
      using Rows = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
      const Eigen::Map<const Rows> two(values.data() + 2 * i * static_cast<std::size_t>(size), 2, size);
      const double s = two.rightCols<1>().squaredNorm();
      gram += kLoss.weight(s) * two.transpose() * two;
      sum_of_rho += kLoss.rho(s);
      num_far += kLoss.weight(s) < 1 ? 1 : 0;
    }
    gram(size - 1, size - 1) = sum_of_rho;
    const auto factor = viewFactor(kernel, set.params, set.poses[v], corners, kLoss, Unseen::kRefuse);
    ASSERT_TRUE(factor);
    const Eigen::MatrixXd made_up = factor->transpose() * *factor;
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j < size; ++j)
        EXPECT_NEAR(made_up(i, j), gram(i, j), 1e-11 * std::sqrt(gram(i, i) * gram(j, j)));
    }
    EXPECT_NEAR(kernel.sumOfRho(set.params.data(), set.poses[v], corners, kLoss), sum_of_rho,
                1e-12 * sum_of_rho);
  }
  EXPECT_GT(num_far, 5);
}

TEST(DiscRows, RefuseADiscOfWhichAPartDoesNotProject) {
  const DiscSet set = discSet<Pinhole>(0);
  const ViewKernel& kernel = viewKernel("pinhole", kNumParams<Pinhole>);
  const auto& view = set.views.front();
  const auto corners = groupsOf(view);
  // Seen edge-on from a millimetre off its middle, a disc reaches behind the camera.
  const SE3 pose{SO3::exp({1.5, 0, 0}), {0, 0, 0.001}};
  EXPECT_FALSE(viewFactor(kernel, set.params, pose, corners, kLoss, Unseen::kRefuse));
  EXPECT_TRUE(viewFactor(kernel, set.params, pose, corners, kLoss, Unseen::kLeaveOut));
  EXPECT_TRUE(std::isnan(kernel.sumOfRho(set.params.data(), pose, corners, kLoss)));
  std::vector<Eigen::Vector2d> errors(view.size());
  kernel.errors(set.params.data(), pose, corners, errors);
  EXPECT_TRUE(std::isnan(errors.front().x()));
}

}  // namespace
}  // namespace alidade
