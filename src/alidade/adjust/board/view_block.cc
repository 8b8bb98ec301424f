// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/view_block.h"

#include <cmath>
#include <optional>

#include "alidade/adjust/board/manifolds.h"
#include "alidade/adjust/board/reduced.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

constexpr Eigen::Index kPose = 6;

}  // namespace

ViewBlock::ViewBlock(const Fit& fit, const FitView& view)
    : camera_(fit.cameras[view.camera]),
      board_(boardOf(fit, view)),
      view_(view),
      loss_(fit.loss),
      kernel_(viewKernel(camera_.model, camera_.params.size())),
      has_rig_pose_(!camera_.is_rig_pose_fixed),
      has_body_pose_(board_.isBodyPoseFree()),
      has_shape_(!board_.is_shape_fixed),
      corners_(groupsOf(cornersOnShape(fit, view))) {
  mutable_parameter_block_sizes()->push_back(kernel_.numParams());
  mutable_parameter_block_sizes()->push_back(7);
  if (has_rig_pose_) mutable_parameter_block_sizes()->push_back(7);
  if (has_body_pose_) mutable_parameter_block_sizes()->push_back(7);
  if (has_shape_) mutable_parameter_block_sizes()->push_back(kNumBends);
  if (view.deviation) {
    mutable_parameter_block_sizes()->push_back(PoseDeviation::kSize);
    if (!camera_.is_delay_fixed) mutable_parameter_block_sizes()->push_back(1);
  }
  set_num_residuals(static_cast<int>(kPose) + kernel_.numParams() + (has_shape_ ? kNumBends : 0) + 1);
}

bool ViewBlock::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  const double* params = blocks[0];
  const SE3 camera_from_rig = has_rig_pose_ ? fromBlock(blocks[2]) : camera_.camera_from_rig;
  const int body_block = has_rig_pose_ ? 3 : 2;
  const std::optional<SE3> body_from_board =
      has_body_pose_ ? fromBlock(blocks[body_block]) : board_.body_from_board;
  const SE3 rig_from_board = body_from_board ? fromBlock(blocks[1]) * *body_from_board : fromBlock(blocks[1]);
  const int shape_block = body_block + (has_body_pose_ ? 1 : 0);
  const int deviation_block = shape_block + (has_shape_ ? 1 : 0);
  const bool has_delay = view_.deviation && !camera_.is_delay_fixed;
  std::optional<PoseDeviation> deviation = view_.deviation;
  if (deviation) deviation->normal = Eigen::Map<const PoseDeviation::Normal>(blocks[deviation_block]);
  const double delay = has_delay ? *blocks[deviation_block + 1] : camera_.delay;
  const Vector6d tangent = deviation ? deviation->tangent(delay) : Vector6d(Vector6d::Zero());
  const SE3 placed = camera_from_rig * rig_from_board;
  const SE3 camera_from_board = deviation ? placed * SE3::exp(tangent) : placed;
  const double* shape = has_shape_ ? blocks[shape_block] : nullptr;
  Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
  if (jacobians == nullptr) {
    // Residuals with the same sum of squares have the same cost, so all of it goes into one.
    const double rho = shape == nullptr
                           ? kernel_.sumOfRho(params, camera_from_board, corners_, loss_)
                           : kernel_.sumOfRho(params, camera_from_board, groupsOf(onBend(shape)), loss_);
    r.setZero();
    r(0) = std::sqrt(rho);
    return std::isfinite(rho);
  }
  RowMajorMatrix rows;
  if (!factor(params, camera_from_board, shape, rows)) return false;
  const Eigen::Index num_params = kernel_.numParams();
  r = rows.rightCols<1>();
  const auto write = [&](int block, const Eigen::MatrixXd& J) {
    if (jacobians[block] != nullptr) Eigen::Map<RowMajorMatrix>(jacobians[block], J.rows(), J.cols()) = J;
  };
  write(0, rows.middleCols(kPose, num_params));
  if (deviation) {
    // P Exp(zeta) Exp(d) = P Exp(d) Exp(Ad(Exp(-d)) zeta).
    const Eigen::MatrixXd by_tangent = rows.leftCols<kPose>() * SE3::rightJacobian(tangent);
    write(deviation_block, by_tangent * deviation->root);
    if (has_delay) write(deviation_block + 1, by_tangent * deviation->tangentByDelay(delay));
    rows.leftCols<kPose>() = (rows.leftCols<kPose>() * SE3::exp(-tangent).adjoint()).eval();
  }
  // P Exp(zeta) B = P B Exp(Ad(B^-1) zeta).
  auto by_placement = tangentByBlock(blocks[1]);
  if (body_from_board) by_placement = (body_from_board->inverse().adjoint() * by_placement).eval();
  write(1, rows.leftCols<kPose>() * by_placement);
  if (has_body_pose_) write(body_block, rows.leftCols<kPose>() * tangentByBlock(blocks[body_block]));
  if (has_rig_pose_) {
    // C Exp(eta) B = C B Exp(Ad(B^-1) eta).
    write(2, rows.leftCols<kPose>() * (rig_from_board.inverse().adjoint() * tangentByBlock(blocks[2])));
  }
  if (has_shape_) write(shape_block, rows.middleCols<kNumBends>(kPose + num_params));
  return true;
}

std::vector<Observation> ViewBlock::onBend(const double* bend_m) const {
  BoardShape shape = board_.shape;
  shape.bend_x_m = bend_m[0] + view_.flex_m.x();
  shape.bend_y_m = bend_m[1] + view_.flex_m.y();
  return onShape(board_.target, shape, view_.corners);
}

bool ViewBlock::factor(const double* params, const SE3& camera_from_board, const double* shape,
                       RowMajorMatrix& rows) const {
  const Eigen::Index size = num_residuals();
  if (shape == nullptr) {
    rows.resize(size, size);
    return kernel_.factor(params, camera_from_board, corners_, loss_, Unseen::kRefuse, rows.data());
  }
  const auto corners = onBend(shape);
  const auto num_params = static_cast<std::size_t>(kernel_.numParams());
  detail::ViewGram of = detail::gramOf(camera_.model, {params, num_params}, camera_from_board, corners, loss_,
                                       LossWeights::kUse, bendColumns(&board_.target));
  if (of.num_corners < static_cast<int>(corners.size())) return false;
  of.lower(size - 1, size - 1) = of.sum_of_rho;
  rows = semidefiniteRootOf(of.lower);
  return rows.allFinite();
}

}  // namespace alidade
