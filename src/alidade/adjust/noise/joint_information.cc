// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/joint_information.h"

#include <map>

#include <Eigen/Cholesky>

namespace alidade {
namespace {

constexpr int kPoseSize = 6;

using PoseRows = Eigen::Matrix<double, kPoseSize, Eigen::Dynamic>;

// Sums of one placement: the unknowns of the fit, their products with the placement's own six unknowns, and
// the error.
struct PlacementSums {
  explicit PlacementSums(int count)
      : JtJ(Eigen::MatrixXd::Zero(count, count)),
        mixed(PoseRows::Zero(kPoseSize, count)),
        Jte(Eigen::VectorXd::Zero(count)) {}

  Eigen::MatrixXd JtJ;  // lower triangle
  PoseRows mixed;
  Eigen::VectorXd Jte;
  Eigen::Matrix<double, kPoseSize, kPoseSize> own = decltype(own)::Zero();
  Eigen::Matrix<double, kPoseSize, 1> own_error = decltype(own_error)::Zero();
  int num_corners = 0;
};

// Adds to the lower triangle, in whichever order the two blocks are.
void addBlock(Eigen::MatrixXd& lower, int row, int column, const Eigen::MatrixXd& block) {
  if (row == column) {
    lower.block(row, row, block.rows(), block.rows()).triangularView<Eigen::Lower>() += block;
  } else if (row > column) {
    lower.block(row, column, block.rows(), block.cols()) += block;
  } else {
    lower.block(column, row, block.cols(), block.rows()) += block.transpose();
  }
}

// Consecutive columns of a view that are also consecutive in the fit.
struct Group {
  int from = 0;  // first column in the view
  int to = 0;    // first column in the fit
  int size = 0;
};

// Adds a view. C Exp(eta) P Exp(zeta) = C P Exp(Ad(P^-1) eta + zeta): the columns of the pose are those of
// the placement and, through the adjoint, those of the camera.
void add(const Fit& fit, const FitView& view, const JointColumns& columns, LossWeights weights,
         PlacementSums& sums) {
  const FitCamera& camera = fit.cameras[view.camera];
  const std::size_t b = boardIndex(fit, view);
  const Board& board = fit.boards[b].target;
  const bool has_bend = columns.bend[b] >= 0;
  const bool has_offsets = columns.offsets[b] >= 0;
  const auto gramWith = [&](const auto& extra) {
    return detail::gramOf(camera.model, camera.params, cameraFromBoard(fit, view), cornersOnShape(fit, view),
                          fit.loss, weights, extra);
  };
  const detail::ViewGram gram = has_offsets ? gramWith(OffsetColumns{board})
                                : has_bend  ? gramWith(BendColumns{.board = &board})
                                            : gramWith(NoExtra{});
  const auto num_params = static_cast<int>(camera.params.size());
  const int error = kPoseSize + num_params;
  const Eigen::Matrix<double, kPoseSize, kPoseSize> pose =
      gram.dense.topLeftCorner<kPoseSize, kPoseSize>().selfadjointView<Eigen::Lower>();
  // The view's columns after the pose: parameters, bends and offsets.
  const auto num_extra = static_cast<int>(gram.extra.rows());
  const int num_offsets = num_extra - kNumBends;
  PoseRows with_pose(kPoseSize, num_params + num_extra);
  with_pose << gram.dense.block(kPoseSize, 0, num_params, kPoseSize).transpose(),
      gram.mixed.leftCols<kPoseSize>().transpose();
  std::vector<Group> groups = {{0, columns.params[view.camera], num_params}};
  if (has_bend) groups.push_back({num_params, columns.bend[b], kNumBends});
  if (has_offsets) groups.push_back({num_params + kNumBends, columns.offsets[b], num_offsets});

  const int rig_pose = columns.pose[view.camera];
  const Eigen::Matrix<double, kPoseSize, kPoseSize> to_camera =
      fit.placements[view.placement].rig_from_board.inverse().adjoint();
  const Eigen::Matrix<double, kPoseSize, 1> pose_error = gram.dense.block<1, kPoseSize>(error, 0).transpose();
  sums.own += pose;
  sums.own_error += pose_error;
  if (rig_pose >= 0) {
    sums.mixed.middleCols<kPoseSize>(rig_pose) += pose * to_camera;
    sums.Jte.segment<kPoseSize>(rig_pose) += to_camera.transpose() * pose_error;
    addBlock(sums.JtJ, rig_pose, rig_pose, to_camera.transpose() * pose * to_camera);
  }
  for (const Group& group : groups) {
    const auto rows = with_pose.middleCols(group.from, group.size);
    sums.mixed.middleCols(group.to, group.size) += rows;
    if (rig_pose >= 0) addBlock(sums.JtJ, rig_pose, group.to, to_camera.transpose() * rows);
    const bool is_lens = group.from == 0;
    const int first = group.from - num_params;
    sums.Jte.segment(group.to, group.size) +=
        is_lens ? Eigen::VectorXd(gram.dense.block(error, kPoseSize, 1, num_params).transpose())
                : Eigen::VectorXd(gram.mixed.col(error).segment(first, group.size));
    if (is_lens) {
      addBlock(sums.JtJ, group.to, group.to, gram.dense.block(kPoseSize, kPoseSize, num_params, num_params));
      continue;
    }
    addBlock(sums.JtJ, group.to, columns.params[view.camera],
             gram.mixed.block(first, kPoseSize, group.size, num_params));
    addBlock(sums.JtJ, group.to, group.to, gram.extra.block(first, first, group.size, group.size));
  }
  if (has_bend && has_offsets) {
    addBlock(sums.JtJ, columns.offsets[b], columns.bend[b],
             gram.extra.block(kNumBends, 0, num_offsets, kNumBends));
  }
  sums.num_corners += gram.num_corners;
}

// Combines the directions of a lens so that its corners determine each equally well.
Eigen::MatrixXd balanced(const Eigen::MatrixXd& directions, const Eigen::MatrixXd& information) {
  if (directions.cols() == 0) return directions;
  const Eigen::MatrixXd own = directions.transpose() * information * directions;
  const Eigen::VectorXd scale = own.diagonal().cwiseSqrt().cwiseInverse();  // because units differ
  const Eigen::LLT<Eigen::MatrixXd> root(scale.asDiagonal() * own * scale.asDiagonal());
  if (root.info() != Eigen::Success || !scale.allFinite()) return directions;
  return directions * scale.asDiagonal() *
         root.matrixU().solve(Eigen::MatrixXd::Identity(own.rows(), own.rows()));
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
      PlacementSums sums(columns.count);
      for (const FitView* view : views) add(fit, *view, columns, weights, sums);
      const Eigen::LDLT<Eigen::Matrix<double, kPoseSize, kPoseSize>> own(sums.own);
      frame.information.triangularView<Eigen::Lower>() += sums.JtJ;
      frame.information.triangularView<Eigen::Lower>() -= sums.mixed.transpose() * own.solve(sums.mixed);
      frame.gradient += sums.Jte - sums.mixed.transpose() * own.solve(sums.own_error);
      frame.num_corners += sums.num_corners;
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
