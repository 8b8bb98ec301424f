// SPDX-License-Identifier: MIT
#pragma once

#include <ceres/cost_function.h>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/board/view_kernel.h"

namespace alidade {

/// The residual block of a view. Its parameter blocks are the intrinsics (N), rig_from_body (SE3Manifold)
/// and, if they are estimated, camera_from_rig and body_from_board (SE3Manifold), the board's shape (2), the
/// scatter of the view's deviation (7) and the camera's delay (1).
///
/// A view has two residuals per corner, and the run time of Ceres is proportional to the number of residuals.
/// The block therefore sums the corners' normal equations [J r]^T [J r], with the loss of each corner, and
/// gives Ceres their triangular factor R: it has as many rows as columns, and R^T R is the same. The last row
/// accounts for the difference between the loss and its quadratic model, so that the cost is exact.
class ViewBlock final : public ceres::CostFunction {
 public:
  /// @param fit  must outlive the block; only the values of its fixed parameters are used
  ViewBlock(const Fit& fit, const FitView& view);

  [[nodiscard]] bool hasRigPose() const { return has_rig_pose_; }
  [[nodiscard]] bool hasBodyPose() const { return has_body_pose_; }
  [[nodiscard]] bool hasShape() const { return has_shape_; }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  // False if a corner does not project.
  [[nodiscard]] bool factor(const double* params, const SE3& camera_from_board, const double* shape,
                            RowMajorMatrix& rows) const;
  // The corners on the board with this bend.
  [[nodiscard]] std::vector<Observation> onBend(const double* bend_m) const;

  const FitCamera& camera_;
  const FitBoard& board_;
  const FitView& view_;
  HuberLoss loss_;
  const ViewKernel& kernel_;
  bool has_rig_pose_;
  bool has_body_pose_;
  bool has_shape_;
  std::vector<CornerGroup> corners_;  // on the present shape, if it is fixed
};

}  // namespace alidade
