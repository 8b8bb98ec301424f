// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_information.h"

#include <map>

#include <Eigen/Cholesky>

#include "alidade/adjust/shape_information.h"

namespace alidade {
namespace {

constexpr int kPoseSize = 6;

// Sums of one placement: the columns of the rig, the placement's own six, and the error.
struct PlacementSums {
  Eigen::MatrixXd JtJ;  // (columns + 6) squared
  Eigen::VectorXd Jte;
  int num_corners = 0;
};

// Adds a view. C Exp(eta) P Exp(zeta) = C P Exp(Ad(P^-1) eta + zeta): the pose's columns are those of the
// placement, and by the adjoint those of the camera.
void add(const Fit& fit, const FitView& view, const RigColumns& columns, PlacementSums& sums) {
  const FitCamera& camera = fit.cameras[view.camera];
  const std::size_t b = boardIndex(fit, view);
  const BendColumns bends{.board = columns.bend[b] < 0 ? nullptr : &fit.boards[b].target};
  const detail::ViewGram gram =
      detail::gramOf(camera.model, camera.params, cameraFromBoard(fit, view), cornersOnShape(fit, view),
                     fit.loss, LossWeights::kLeaveOut, bends);
  const auto num_params = static_cast<int>(camera.params.size());
  const int num_own = kPoseSize + num_params + kNumBends;
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(num_own, num_own);
  const Eigen::MatrixXd dense = gram.dense.selfadjointView<Eigen::Lower>();
  own.topLeftCorner(kPoseSize + num_params, kPoseSize + num_params) =
      dense.topLeftCorner(kPoseSize + num_params, kPoseSize + num_params);
  own.bottomLeftCorner(kNumBends, kPoseSize + num_params) = gram.mixed.leftCols(kPoseSize + num_params);
  own.topRightCorner(kPoseSize + num_params, kNumBends) =
      gram.mixed.leftCols(kPoseSize + num_params).transpose();
  own.bottomRightCorner<kNumBends, kNumBends>() = gram.extra.selfadjointView<Eigen::Lower>();
  Eigen::VectorXd error(num_own);
  error << dense.col(kPoseSize + num_params).head(kPoseSize + num_params),
      gram.mixed.col(kPoseSize + num_params);

  // From the view's own columns to all.
  Eigen::MatrixXd to_all = Eigen::MatrixXd::Zero(num_own, columns.count + kPoseSize);
  to_all.block<kPoseSize, kPoseSize>(0, columns.count).setIdentity();
  if (const int at = columns.pose[view.camera]; at >= 0)
    to_all.block<kPoseSize, kPoseSize>(0, at) =
        fit.placements[view.placement].rig_from_board.inverse().adjoint();
  to_all.block(kPoseSize, columns.params[view.camera], num_params, num_params).setIdentity();
  if (columns.bend[b] >= 0)
    to_all.block<kNumBends, kNumBends>(kPoseSize + num_params, columns.bend[b]).setIdentity();
  sums.JtJ += to_all.transpose() * own * to_all;
  sums.Jte += to_all.transpose() * error;
  sums.num_corners += gram.num_corners;
}

}  // namespace

std::vector<Reduced> rigInformation(const Fit& fit, const RigColumns& columns) {
  const int size = columns.count + kPoseSize;
  std::vector<PlacementSums> placements(
      fit.placements.size(), {.JtJ = Eigen::MatrixXd::Zero(size, size), .Jte = Eigen::VectorXd::Zero(size)});
  for (const FitView& view : fit.views) add(fit, view, columns, placements[view.placement]);
  std::map<std::size_t, Reduced> frames;
  for (std::size_t p = 0; p < placements.size(); ++p) {
    const PlacementSums& sums = placements[p];
    const auto own = sums.JtJ.bottomRightCorner<kPoseSize, kPoseSize>();
    const Eigen::LDLT<Eigen::Matrix<double, kPoseSize, kPoseSize>> inverse(own);
    const Eigen::MatrixXd mixed = sums.JtJ.bottomLeftCorner(kPoseSize, columns.count);
    const auto [entry, is_new] = frames.try_emplace(fit.placements[p].frame);
    Reduced& frame = entry->second;
    if (is_new) {
      frame.information = Eigen::MatrixXd::Zero(columns.count, columns.count);
      frame.gradient = Eigen::VectorXd::Zero(columns.count);
    }
    frame.information +=
        sums.JtJ.topLeftCorner(columns.count, columns.count) - mixed.transpose() * inverse.solve(mixed);
    frame.gradient +=
        sums.Jte.head(columns.count) - mixed.transpose() * inverse.solve(sums.Jte.tail<kPoseSize>());
    frame.num_corners += sums.num_corners;
  }
  std::vector<Reduced> all;
  for (auto& [frame, reduced] : frames) all.push_back(std::move(reduced));
  return all;
}

Eigen::MatrixXd rigDirections(const Fit& fit, const RigColumns& columns) {
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(columns.count, columns.count);
  Eigen::Index free = 0;
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    const auto num_params = static_cast<int>(fit.cameras[c].params.size());
    const Eigen::MatrixXd of_camera = freeDirections(num_params, fit.cameras[c].constraint);
    directions.block(columns.params[c], free, num_params, of_camera.cols()) = of_camera;
    free += of_camera.cols();
  }
  for (int column = columns.params.back() + static_cast<int>(fit.cameras.back().params.size());
       column < columns.count; ++column)
    directions(column, free++) = 1;
  return directions.leftCols(free);
}

}  // namespace alidade
