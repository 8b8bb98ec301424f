// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/reduced.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "alidade/adjust/board/view_kernel.h"
#include "alidade/core/mapped.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/target/board_shape.h"

namespace alidade {
namespace {

using Elements = std::vector<std::pair<int, double>>;

// A shift of the board along its own z is a shift of the point.
void addBends(const Board& board, int first, const CornerRows& rows, int axis, Elements& to) {
  const Eigen::Vector3d& p = board.corner(rows.corner.id);
  const Eigen::Vector2d profile = bendProfile(board, p.x(), p.y());
  const double J_px_z = rows.J_px_pose[static_cast<std::size_t>(axis)][2];
  to.emplace_back(first, J_px_z * profile.x());
  to.emplace_back(first + 1, J_px_z * profile.y());
}

// Eliminates the pose.
Reduced eliminatePose(const detail::ViewGram& gram) {
  const Eigen::MatrixXd& sums = gram.lower;
  const Eigen::Index size = sums.rows() - 7;
  const Eigen::Index error = 6 + size;
  const Eigen::MatrixXd pose = sums.topLeftCorner<6, 6>().selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd coupling = sums.bottomLeftCorner(size + 1, 6).transpose();
  Reduced reduced{.information = sums.block(6, 6, size, size),
                  .gradient = sums.row(error).segment(6, size).transpose(),
                  .squares = sums(error, error),
                  .num_corners = gram.num_corners};
  auto& information = reduced.information;
  const Eigen::MatrixXd solved = solveSpd(pose, coupling);
  information.triangularView<Eigen::Lower>() -= coupling.leftCols(size).transpose() * solved.leftCols(size);
  information.triangularView<Eigen::StrictlyUpper>() = information.transpose();
  reduced.gradient -= coupling.leftCols(size).transpose() * solved.col(size);
  reduced.squares -= coupling.col(size).dot(solved.col(size));
  return reduced;
}

}  // namespace

ExtraColumns bendColumns(const Board* board, int first, int num_columns) {
  ExtraColumns columns;
  columns.size = num_columns;
  columns.addElements = [board, first](const CornerRows& rows, int axis, Elements& to) {
    if (board != nullptr) addBends(*board, first, rows, axis, to);
  };
  return columns;
}

detail::ViewGram detail::gramOf(std::string_view model_id, std::span<const double> params,
                                const SE3& camera_from_board, std::span<const Observation> view,
                                HuberLoss loss, LossWeights weights, const ExtraColumns& extra,
                                PointShifts shifts) {
  const ViewKernel& kernel = viewKernel(model_id, params.size());
  const Eigen::Index error = kernel.numParams() + 6;  // in the dense rows: pose, parameters, error
  const Eigen::Index last = error + extra.size;       // among all columns
  ViewFactor dense(2 * static_cast<Eigen::Index>(view.size()), error + 1);
  kernel.rows(params.data(), camera_from_board, groupsOf(view),
              {dense.data(), static_cast<std::size_t>(dense.size())});
  ViewGram gram{.lower = Eigen::MatrixXd::Zero(last + 1, last + 1), .points = {}};
  if (shifts == PointShifts::kInclude)
    gram.points = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(view.size()), last + 1);
  Eigen::Index num_rows = 0;
  Elements elements;
  for (std::size_t i = 0; i < view.size(); ++i) {
    constexpr Eigen::Index kCx = 6 + 2;
    const auto from = static_cast<Eigen::Index>(2 * i);
    const double root_weight = dense(from, kCx);  // as the pixel moves with the principal point
    if (!(root_weight > 0)) continue;
    if (num_rows != from) dense.middleRows<2>(num_rows) = dense.middleRows<2>(from);
    const double* u = dense.row(num_rows).data();
    const double* v = u + error + 1;
    const double s = u[error] * u[error] + v[error] * v[error];
    gram.sum_of_rho += loss.rho(s);
    // Rows include the square root of the information's weight, and the error is scaled to give the weight of
    // the gradient.
    const double weight = loss.weight(s);
    const double root = weights == LossWeights::kUse ? std::sqrt(weight) : 1.0;
    const CornerRows rows{.corner = view[i],
                          .camera_from_board = camera_from_board,
                          .root_weight = root_weight,
                          .J_px_pose = {u, v},
                          .J_px_params = {u + 6, v + 6},
                          .error = {u[error], v[error]}};
    for (int axis = 0; axis < 2; ++axis) {
      elements.clear();
      if (extra.size > 0) extra.addElements(rows, axis, elements);
      auto row = dense.row(num_rows++);
      row.head(error) *= root;
      row(error) *= weight / root;
      for (std::size_t a = 0; a < elements.size(); ++a) {
        elements[a].second *= root;
        const Eigen::Index at = error + elements[a].first;
        gram.lower.row(at).head(error) += elements[a].second * row.head(error);
        gram.lower(last, at) += elements[a].second * row(error);
        for (std::size_t b = 0; b <= a; ++b) {
          const Eigen::Index other = error + elements[b].first;
          gram.lower(std::max(at, other), std::min(at, other)) += elements[a].second * elements[b].second;
        }
      }
      if (shifts == PointShifts::kLeaveOut) continue;
      auto point = gram.points.middleRows<3>(3 * gram.num_corners);
      const Eigen::Vector3d shift = row.head<3>();  // acts like a translation of the pose
      point.leftCols(error) += shift * row.head(error);
      point.col(last) += shift * row(error);
      for (const auto& [at, value] : elements) point.col(error + at) += shift * value;
    }
    if (shifts == PointShifts::kInclude) gram.ids.push_back(view[i].id);
    ++gram.num_corners;
  }
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(error + 1, error + 1);
  products.selfadjointView<Eigen::Lower>().rankUpdate(dense.topRows(num_rows).transpose());
  gram.lower.topLeftCorner(error, error) = products.topLeftCorner(error, error);
  gram.lower.row(last).head(error) = products.row(error).head(error);
  gram.lower(last, last) = products(error, error);
  return gram;
}

Reduced reducedByPose(const Fit& fit, const FitView& view, LossWeights weights, const ExtraColumns& extra) {
  const FitCamera& camera = fit.cameras[view.camera];
  return eliminatePose(detail::gramOf(camera.model, camera.params, cameraFromBoard(fit, view),
                                      cornersOnShape(fit, view), fit.loss, weights, extra));
}

Reduced reduced(const Fit& fit, const FitView& view, LossWeights weights, const ExtraColumns& extra) {
  const FitBoard& board = boardOf(fit, view);
  if (!board.isFlexible()) return reducedByPose(fit, view, weights, extra);
  const ExtraColumns bends = bendColumns(&board.target, extra.size);
  ExtraColumns both;
  both.size = extra.size + kNumBends;
  both.addElements = [&](const CornerRows& rows, int axis, Elements& to) {
    if (extra.size > 0) extra.addElements(rows, axis, to);
    bends.addElements(rows, axis, to);
  };
  Reduced all = reducedByPose(fit, view, weights, both);
  const Eigen::Index size = all.gradient.size() - kNumBends;
  const Eigen::Matrix2d own = all.information.bottomRightCorner<kNumBends, kNumBends>() +
                              board.flex.precision * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d pull = all.gradient.tail<kNumBends>() + board.flex.precision * view.flex_m;
  const Eigen::MatrixXd coupling = all.information.topRightCorner(size, kNumBends) * own.inverse();
  return {.information = all.information.topLeftCorner(size, size) -
                         coupling * all.information.bottomLeftCorner(kNumBends, size),
          .gradient = all.gradient.head(size) - coupling * pull,
          .squares = all.squares,
          .num_corners = all.num_corners};
}

std::vector<Reduced> reduced(const Fit& fit, LossWeights weights, const ExtraColumns& extra) {
  return mapped(fit.views, [&](const FitView& view) { return reduced(fit, view, weights, extra); });
}

}  // namespace alidade
