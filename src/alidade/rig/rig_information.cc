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

  // From the view's own columns to those of the rig that it concerns.
  std::vector<int> concerned;
  const auto concern = [&](int first, int count) {
    for (int i = 0; i < count; ++i) concerned.push_back(first + i);
  };
  const int pose = columns.pose[view.camera];
  concern(columns.count, kPoseSize);
  if (pose >= 0) concern(pose, kPoseSize);
  concern(columns.params[view.camera], num_params);
  if (columns.bend[b] >= 0) concern(columns.bend[b], kNumBends);
  Eigen::MatrixXd to_rig = Eigen::MatrixXd::Zero(num_own, static_cast<Eigen::Index>(concerned.size()));
  to_rig.leftCols<kPoseSize>().topRows<kPoseSize>().setIdentity();
  int at = kPoseSize;
  if (pose >= 0) {
    to_rig.block<kPoseSize, kPoseSize>(0, at) =
        fit.placements[view.placement].rig_from_board.inverse().adjoint();
    at += kPoseSize;
  }
  to_rig.block(kPoseSize, at, num_params, num_params).setIdentity();
  if (columns.bend[b] >= 0) to_rig.bottomRightCorner<kNumBends, kNumBends>().setIdentity();
  sums.JtJ(concerned, concerned) += to_rig.transpose() * own * to_rig;
  sums.Jte(concerned) += to_rig.transpose() * error;
  sums.num_corners += gram.num_corners;
}

// Directions of a lens combined so that its corners know each equally well.
Eigen::MatrixXd balanced(const Eigen::MatrixXd& directions, const Eigen::MatrixXd& information) {
  if (directions.cols() == 0) return directions;
  const Eigen::MatrixXd own = directions.transpose() * information * directions;
  const Eigen::VectorXd scale = own.diagonal().cwiseSqrt().cwiseInverse();  // units differ
  const Eigen::LLT<Eigen::MatrixXd> root(scale.asDiagonal() * own * scale.asDiagonal());
  if (root.info() != Eigen::Success || !scale.allFinite()) return directions;
  return directions * scale.asDiagonal() *
         root.matrixU().solve(Eigen::MatrixXd::Identity(own.rows(), own.rows()));
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

Eigen::MatrixXd rigDirections(const Fit& fit, const RigColumns& columns, const Eigen::MatrixXd& information) {
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
