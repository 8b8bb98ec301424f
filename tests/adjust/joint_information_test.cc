// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/joint_information.h"

#include <gtest/gtest.h>

#include "alidade/adjust/noise/board_offsets.h"
#include "support/bundle_set.h"

namespace alidade {
namespace {

// The offsets of all points of a board as further columns, whose equations are then full.
struct OffsetsInFull {
  int num_points;
  [[nodiscard]] int size() const { return 3 * num_points; }
  static ExtraElements<3> elements(const CornerRows& rows, int axis) {
    const double* J_px_point = rows.J_px_pose[static_cast<std::size_t>(axis)];
    const int first = 3 * rows.corner.id;
    return {.column = {first, first + 1, first + 2}, .value = {J_px_point[0], J_px_point[1], J_px_point[2]}};
  }
};

void expectClose(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
  ASSERT_EQ(found.rows(), expected.rows());
  ASSERT_EQ(found.cols(), expected.cols());
  EXPECT_LT((found - expected).norm(), 1e-11 * expected.norm());
}

TEST(JointInformation, OfOffsetsIsTheSameInFullAndAsRoots) {
  constexpr HuberLoss kJointLoss{.threshold_px = 1.5};
  for (const int num_views : {4, 40}) {
    Fit fit = startedUneven(bundleSet<Radtan>(num_views, 15, kJointLoss), std::vector<std::size_t>{0});
    FitBoard& board = fit.boards.front();
    Random random(8);
    for (Eigen::Vector3d& offset_m : board.shape.offsets_m)
      for (double& x : offset_m) x = 1e-4 * random.normal();
    const JointColumns columns = jointColumns(fit, Offsets::kInclude);
    const Eigen::Index num_offsets = 3 * board.target.numCorners();
    const Eigen::Index num_others = columns.num_others;
    ASSERT_EQ(columns.count, num_others + num_offsets);
    for (const LossWeights weights : {LossWeights::kUse, LossWeights::kLeaveOut}) {
      const JointEquations found = jointEquations(fit, columns, weights);
      Eigen::MatrixXd information = Eigen::MatrixXd::Zero(columns.count, columns.count);
      Eigen::VectorXd gradient = Eigen::VectorXd::Zero(columns.count);
      for (const FitView& view : fit.views) {
        const Reduced of_view = reducedByPose(fit, view, weights, OffsetsInFull{board.target.numCorners()});
        information += of_view.information;
        gradient += of_view.gradient;
      }
      EXPECT_EQ(found.of_offsets.full.size() > 0, num_views == 40);
      expectClose(found.information, information.leftCols(num_others));
      expectClose(found.of_offsets.times(Eigen::MatrixXd::Identity(num_offsets, num_offsets)),
                  information.bottomRightCorner(num_offsets, num_offsets));
      expectClose(found.of_offsets.diagonal(), information.diagonal().tail(num_offsets));
      expectClose(found.gradient, gradient);
    }
  }
}

}  // namespace
}  // namespace alidade
