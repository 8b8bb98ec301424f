// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/joint_information.h"

#include <algorithm>
#include <map>

#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

constexpr int kPoseSize = 6;
using PoseRows = Eigen::Matrix<double, kPoseSize, Eigen::Dynamic>;

// The columns that are eliminated from the equations of a placement: its pose, and the bends that a flexible
// board has there.
int numOwn(const FitBoard& board) {
  return kPoseSize + (board.isFlexible() ? kNumBends : 0);
}

// Adds a view to the lower triangle of the sums of its placement, whose columns are those of the placement,
// the unknowns of the fit, and the error.
// C Exp(eta) P Exp(zeta) = C P Exp(Ad(P^-1) eta + zeta): the columns of the pose are those of the placement
// and, through the adjoint, those of the camera.
// @returns the number of corners
int add(const Fit& fit, const FitView& view, const JointColumns& columns, LossWeights weights,
        Eigen::MatrixXd& sums) {
  const FitCamera& camera = fit.cameras[view.camera];
  const std::size_t b = boardIndex(fit, view);
  const Board& board = fit.boards[b].target;
  const int num_own = numOwn(fit.boards[b]);
  const bool has_flex = num_own > kPoseSize;
  const bool has_bend = columns.bend[b] >= 0;
  const bool has_offsets = columns.offsets[b] >= 0;
  const detail::ViewGram gram = detail::gramOf(camera.model, camera.params, cameraFromBoard(fit, view),
                                               cornersOnShape(fit, view), fit.loss, weights,
                                               has_offsets            ? offsetColumns(board)
                                               : has_bend || has_flex ? bendColumns(&board)
                                                                      : ExtraColumns());
  // For each column of the view, the column of the sums; -1 if it is not estimated.
  std::vector<Eigen::Index> to;
  const auto place = [&](int first, Eigen::Index count) {
    for (Eigen::Index i = 0; i < count; ++i) to.push_back(first < 0 ? -1 : num_own + first + i);
  };
  const auto num_params = static_cast<Eigen::Index>(camera.params.size());
  for (Eigen::Index i = 0; i < kPoseSize; ++i) to.push_back(i);
  place(columns.params[view.camera], num_params);
  if (has_flex) to.insert(to.end(), {kPoseSize, kPoseSize + 1});
  if (!has_flex && (has_bend || has_offsets)) place(columns.bend[b], kNumBends);
  if (has_offsets) place(columns.offsets[b], 3 * board.numCorners());
  place(columns.count, 1);
  const auto at = [&](Eigen::Index i, Eigen::Index j) -> double& {
    return sums(std::max(i, j), std::min(i, j));
  };
  const Eigen::Index size = gram.lower.rows();
  for (Eigen::Index j = 0; j < size; ++j) {
    for (Eigen::Index i = j; i < size; ++i) {
      const Eigen::Index row = to[static_cast<std::size_t>(i)];
      const Eigen::Index column = to[static_cast<std::size_t>(j)];
      if (row >= 0 && column >= 0) at(row, column) += gram.lower(i, j);
    }
  }
  if (columns.pose[view.camera] < 0) return gram.num_corners;
  const Eigen::Index first = num_own + columns.pose[view.camera];
  const Matrix6d pose = gram.lower.topLeftCorner<kPoseSize, kPoseSize>().selfadjointView<Eigen::Lower>();
  const Matrix6d to_camera = fit.placements[view.placement].rig_from_board.inverse().adjoint();
  const Matrix6d with_own = pose * to_camera;
  const Matrix6d with_itself = to_camera.transpose() * pose * to_camera;
  const PoseRows rows = gram.lower.bottomLeftCorner(size - kPoseSize, kPoseSize).transpose();
  const PoseRows with_rest = to_camera.transpose() * rows;
  for (Eigen::Index i = 0; i < kPoseSize; ++i) {
    for (Eigen::Index j = 0; j < kPoseSize; ++j) at(first + i, j) += with_own(j, i);
    for (Eigen::Index j = 0; j <= i; ++j) at(first + i, first + j) += with_itself(i, j);
    for (Eigen::Index j = 0; j < rows.cols(); ++j) {
      const Eigen::Index column = to[static_cast<std::size_t>(kPoseSize + j)];
      if (column >= 0) at(first + i, column) += with_rest(i, j);
    }
  }
  return gram.num_corners;
}

// Combines the directions of a lens so that its corners determine each equally well.
Eigen::MatrixXd balanced(const Eigen::MatrixXd& directions, const Eigen::MatrixXd& information) {
  if (directions.cols() == 0) return directions;
  const Eigen::MatrixXd own = directions.transpose() * information * directions;
  const Eigen::VectorXd scale = own.diagonal().cwiseSqrt().cwiseInverse();  // because units differ
  const auto inverse_root = inverseRootOf(scale.asDiagonal() * own * scale.asDiagonal());
  if (!inverse_root || !scale.allFinite()) return directions;
  return directions * scale.asDiagonal() * *inverse_root;
}

}  // namespace

JointColumns jointColumns(const Fit& fit, Offsets offsets) {
  JointColumns columns;
  const auto take = [&](bool is_free, int size) {
    const int first = is_free ? columns.count : -1;
    columns.count += is_free ? size : 0;
    return first;
  };
  for (const FitCamera& camera : fit.cameras)
    columns.params.push_back(take(true, static_cast<int>(camera.params.size())));
  for (const FitCamera& camera : fit.cameras)
    columns.pose.push_back(take(!camera.is_rig_pose_fixed, kPoseSize));
  for (const FitBoard& board : fit.boards) columns.bend.push_back(take(!board.is_shape_fixed, kNumBends));
  for (const FitBoard& board : fit.boards) {
    const bool is_free = offsets == Offsets::kInclude && board.isUneven();
    columns.offsets.push_back(take(is_free, 3 * board.target.numCorners()));
  }
  return columns;
}

void forEachFrame(const Fit& fit, const JointColumns& columns, LossWeights weights,
                  const std::function<void(const Reduced&)>& visit) {
  // Frames, their placements, and the views of the placements.
  std::map<std::size_t, std::map<std::size_t, std::vector<const FitView*>>> frames;
  for (const FitView& view : fit.views)
    frames[fit.placements[view.placement].frame][view.placement].push_back(&view);
  for (const auto& [index, placements] : frames) {
    Reduced frame{.information = Eigen::MatrixXd::Zero(columns.count, columns.count),
                  .gradient = Eigen::VectorXd::Zero(columns.count)};
    for (const auto& [placement, views] : placements) {
      const FitBoard& board = fit.boards[fit.placements[placement].board];
      const Eigen::Index num_own = numOwn(board);
      const Eigen::Index error = num_own + columns.count;
      Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(error + 1, error + 1);
      for (const FitView* view : views) frame.num_corners += add(fit, *view, columns, weights, sums);
      for (Eigen::Index i = kPoseSize; i < num_own; ++i) {
        sums(i, i) += board.flex.precision;
        sums(error, i) += board.flex.precision * views.front()->flex_m(i - kPoseSize);
      }
      const Eigen::MatrixXd own = sums.topLeftCorner(num_own, num_own).selfadjointView<Eigen::Lower>();
      const Eigen::MatrixXd mixed = sums.block(num_own, 0, columns.count, num_own).transpose();
      const Eigen::VectorXd own_error = sums.row(error).head(num_own).transpose();
      frame.information.triangularView<Eigen::Lower>() +=
          sums.block(num_own, num_own, columns.count, columns.count);
      frame.information.triangularView<Eigen::Lower>() -= mixed.transpose() * solveSpd(own, mixed);
      frame.gradient += sums.row(error).segment(num_own, columns.count).transpose() -
                        mixed.transpose() * solveSpd(own, own_error);
    }
    frame.information.triangularView<Eigen::StrictlyUpper>() = frame.information.transpose();
    visit(frame);
  }
}

std::vector<Reduced> jointInformation(const Fit& fit, const JointColumns& columns) {
  std::vector<Reduced> all;
  forEachFrame(fit, columns, LossWeights::kLeaveOut, [&](const Reduced& frame) { all.push_back(frame); });
  return all;
}

Eigen::MatrixXd jointDirections(const Fit& fit, const JointColumns& columns,
                                const Eigen::MatrixXd& information) {
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(columns.count, columns.count);
  Eigen::Index free = 0;
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    const auto num_params = static_cast<int>(fit.cameras[c].params.size());
    const int at = columns.params[c];
    const Eigen::MatrixXd of_lens = balanced(freeDirections(num_params, fit.cameras[c].constraint),
                                             information.block(at, at, num_params, num_params));
    directions.block(at, free, num_params, of_lens.cols()) = of_lens;
    free += of_lens.cols();
  }
  for (int column = columns.params.back() + static_cast<int>(fit.cameras.back().params.size());
       column < columns.count; ++column)
    directions(column, free++) = 1;
  return directions.leftCols(free);
}

}  // namespace alidade
