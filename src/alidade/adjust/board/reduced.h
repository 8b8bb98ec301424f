// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/target/board_shape.h"

namespace alidade {

/// The normal equations of one view with its pose eliminated (Schur complement): the information of the view
/// about the intrinsics and any further columns, with a free pose.
struct Reduced {
  Eigen::MatrixXd information;  ///< J^T W J, K x K for N parameters and K - N further columns, per px^2
  Eigen::VectorXd gradient;     ///< J^T W psi, where psi is the error times the loss weight; 0 over all views
                                ///< at the optimum, in the columns of free parameters
  double squares = 0;   ///< weighted sum of squared errors that no pose removes, px^2; with LossWeights::kUse
  int num_corners = 0;  ///< number of corners that project
};

/// Use of the loss weights in the information. The gradient always includes them.
enum class LossWeights {
  kLeaveOut,  ///< information of a fit without a loss
  kUse,       ///< information of iteratively reweighted least squares
};

/// A corner as the input of further columns. The Jacobians and the error of each axis include the square root
/// of the weight.
struct CornerRows {
  const Observation& corner;
  const SE3& camera_from_board;
  double root_weight;
  std::array<const double*, 2> J_px_pose;    ///< 6 for u, 6 for v: translation, rotation
  std::array<const double*, 2> J_px_params;  ///< N each
  std::array<double, 2> error;               ///< projected minus observed
};

/// Non-zero elements of the further columns in one row.
template <std::size_t kCount>
struct ExtraElements {
  std::array<int, kCount> column;
  std::array<double, kCount> value;  ///< including the square root of the corner's weight
};

/// Columns that are appended to the Jacobian after the intrinsics: derivatives of the corner's pixel with
/// respect to unknowns other than pose and intrinsics. Few of them are non-zero in any row.
template <class Extra>
concept ExtraColumns = requires(const Extra& extra, const CornerRows& rows, int axis) {
  { extra.size() } -> std::convertible_to<int>;
  { extra.elements(rows, axis).column[0] } -> std::convertible_to<int>;
};

struct NoExtra {
  static int size() { return 0; }
  static ExtraElements<0> elements(const CornerRows&, int) { return {}; }
};

/// Number of columns for the BoardShape of a board, after those of the intrinsics.
inline constexpr int kNumBends = 2;

/// bend_x and bend_y of the shapes of boards as further columns, for the views of one board.
struct BendColumns {
  const Board* board = nullptr;  ///< board of the view; null if its bend is not among the columns
  int first = 0;                 ///< its first column
  int num_columns = kNumBends;   ///< of all boards

  [[nodiscard]] int size() const { return num_columns; }
  [[nodiscard]] ExtraElements<kNumBends> elements(const CornerRows& rows, int axis) const {
    if (board == nullptr) return {.column = {0, 1}, .value = {0, 0}};
    const Eigen::Vector3d& p = board->corner(rows.corner.id);
    const Eigen::Vector2d profile = bendProfile(*board, p.x(), p.y());
    // A shift of the board along its own z is a shift of the point.
    const double J_px_z = rows.J_px_pose[static_cast<std::size_t>(axis)][2];
    return {.column = {first, first + 1}, .value = {J_px_z * profile.x(), J_px_z * profile.y()}};
  }
};

/// bend_x and bend_y of a board, followed by the offset of each of its points, for the views of this board.
struct OffsetColumns {
  const Board& board;

  [[nodiscard]] int size() const { return kNumBends + 3 * board.numCorners(); }
  [[nodiscard]] ExtraElements<kNumBends + 3> elements(const CornerRows& rows, int axis) const {
    const auto bends = BendColumns{.board = &board}.elements(rows, axis);
    const double* J_px_point = rows.J_px_pose[static_cast<std::size_t>(axis)];  // same as a shift of the
                                                                                // board
    const int point = kNumBends + 3 * rows.corner.id;
    return {.column = {0, 1, point, point + 1, point + 2},
            .value = {bends.value[0], bends.value[1], J_px_point[0], J_px_point[1], J_px_point[2]}};
  }
};

namespace detail {

/// Two rows per corner that projects: pose, parameters, error, including the square root of the weight of the
/// corner.
struct WeightedRows {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Matrix rows;
  std::vector<std::size_t> corner;  ///< index of the corner of each pair of rows
  std::vector<double> root_weight;  ///< of the same corner
  std::vector<double> loss_weight;  ///< of the same corner
};

[[nodiscard]] WeightedRows weightedRows(std::string_view model_id, std::span<const double> params,
                                        const SE3& camera_from_board, std::span<const Observation> view,
                                        HuberLoss loss);

/// Sums of products of the dense columns (pose, parameters, error) and of the further columns.
struct ViewGram {
  Eigen::MatrixXd dense;  ///< lower triangle
  Eigen::MatrixXd mixed;  ///< one row for each further column
  Eigen::MatrixXd extra;  ///< lower triangle
  double sum_of_rho = 0;
  int num_corners = 0;  ///< number of corners that project
};

/// Corners that do not project are skipped.
template <ExtraColumns Extra>
[[nodiscard]] ViewGram gramOf(std::string_view model_id, std::span<const double> params,
                              const SE3& camera_from_board, std::span<const Observation> view, HuberLoss loss,
                              LossWeights weights, const Extra& extra) {
  WeightedRows of = weightedRows(model_id, params, camera_from_board, view, loss);
  const Eigen::Index num_dense = of.rows.cols();
  const int num_params = static_cast<int>(num_dense) - 7;
  const auto num_extra = static_cast<Eigen::Index>(extra.size());
  ViewGram gram{.dense = Eigen::MatrixXd::Zero(num_dense, num_dense),
                .mixed = Eigen::MatrixXd::Zero(num_extra, num_dense),
                .extra = Eigen::MatrixXd::Zero(num_extra, num_extra),
                .num_corners = static_cast<int>(of.corner.size())};
  for (std::size_t i = 0; i < of.corner.size(); ++i) {
    double* u = of.rows.row(static_cast<Eigen::Index>(2 * i)).data();
    double* v = u + num_dense;
    gram.sum_of_rho +=
        loss.rho(u[6 + num_params] * u[6 + num_params] + v[6 + num_params] * v[6 + num_params]);
    // Rows include the square root of the information's weight, and the error is scaled to give the weight of
    // the gradient.
    const double weight = of.loss_weight[i];
    const double root = weights == LossWeights::kUse ? std::sqrt(weight) : 1.0;
    const CornerRows rows{.corner = view[of.corner[i]],
                          .camera_from_board = camera_from_board,
                          .root_weight = of.root_weight[i],
                          .J_px_pose = {u, v},
                          .J_px_params = {u + 6, v + 6},
                          .error = {u[6 + num_params], v[6 + num_params]}};
    for (int axis = 0; axis < 2; ++axis) {
      auto elements = extra.elements(rows, axis);
      auto row = of.rows.row(static_cast<Eigen::Index>(2 * i) + axis);
      row.head(num_dense - 1) *= root;
      row(num_dense - 1) *= weight / root;
      for (std::size_t a = 0; a < elements.column.size(); ++a) {
        elements.value[a] *= root;
        const auto at = static_cast<Eigen::Index>(elements.column[a]);
        gram.mixed.row(at) += elements.value[a] * row;
        for (std::size_t b = 0; b <= a; ++b) {
          const auto other = static_cast<Eigen::Index>(elements.column[b]);
          gram.extra(std::max(at, other), std::min(at, other)) += elements.value[a] * elements.value[b];
        }
      }
    }
  }
  gram.dense.selfadjointView<Eigen::Lower>().rankUpdate(of.rows.transpose());
  return gram;
}

/// Eliminates the pose.
[[nodiscard]] Reduced eliminatePose(const ViewGram& gram);

}  // namespace detail

/// The equations of one view, see Reduced. Corners that do not project are skipped.
template <ExtraColumns Extra = NoExtra>
[[nodiscard]] Reduced reduced(const Fit& fit, const FitView& view, LossWeights weights,
                              const Extra& extra = {}) {
  const FitCamera& camera = fit.cameras[view.camera];
  return detail::eliminatePose(detail::gramOf(camera.model, camera.params, cameraFromBoard(fit, view),
                                              cornersOnShape(fit, view), fit.loss, weights, extra));
}

/// One per view, in the order of the views.
template <ExtraColumns Extra = NoExtra>
[[nodiscard]] std::vector<Reduced> reduced(const Fit& fit, LossWeights weights, const Extra& extra = {}) {
  std::vector<Reduced> all;
  all.reserve(fit.views.size());
  for (const FitView& view : fit.views) all.push_back(reduced(fit, view, weights, extra));
  return all;
}

}  // namespace alidade
