// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/reduced.h"
#include "alidade/target/board_shape.h"

namespace alidade {

/// Number of columns for the BoardShape of a board, after those of the intrinsics.
inline constexpr int kNumBends = 2;

/// bend_x and bend_y of boards' shapes as further columns, for the views of one board.
struct BendColumns {
  const Board* board = nullptr;  ///< that the view shows; null: one whose bend is not among the columns
  int first = 0;                 ///< its first column
  int num_columns = kNumBends;   ///< of all boards

  [[nodiscard]] int size() const { return num_columns; }
  [[nodiscard]] ExtraElements<kNumBends> elements(const CornerRows& rows, int axis) const {
    if (board == nullptr) return {.column = {0, 1}, .value = {0, 0}};
    const Eigen::Vector2d profile = bendProfile(*board, rows.corner.p_board.x(), rows.corner.p_board.y());
    // A shift of the board along its own z is a shift of the point.
    const double J_px_z = rows.J_px_pose[static_cast<std::size_t>(axis)][2];
    return {.column = {first, first + 1}, .value = {J_px_z * profile.x(), J_px_z * profile.y()}};
  }
};

/// The information of the corners about the bends of boards (BoardShape) at a solution, with poses and
/// intrinsics refitted for every change of a bend. The columns of the bends are bend_x and bend_y of each
/// board in turn.
struct ShapeInformation {
  std::vector<std::size_t> boards;  ///< whose bends are free; indices into Fit::boards
  Eigen::VectorXd step_m;           ///< the change of the bends to the minimum of a parabola
  Eigen::VectorXd params_step;      ///< the change of the intrinsics with it
  double drop = 0;                  ///< of twice the cost by this step, px^2 of a corner of weight 1
  /// (J^T W J)^-1 restricted to the bends, m^2 / px^2, and to the intrinsics, with bends and poses free.
  /// Multiplied by the variance of a corner of weight 1, they are covariances.
  Eigen::MatrixXd bend_inverse;
  Eigen::MatrixXd params_inverse;
  /// The information of each place, see placesOf(), at the end of the step, without the weights of the loss.
  std::vector<Reduced> pulls;
  Eigen::MatrixXd prior;  ///< the prior information, per px^2, with rows like those of the pulls
};

/// Free directions of the intrinsics, see freeDirections(), followed by those of the bends.
[[nodiscard]] Eigen::MatrixXd withBends(const Eigen::MatrixXd& directions, Eigen::Index num_columns);

/// @param fit     of one camera, at the optimum for the boards' present shapes
/// @param boards  at least one; the others keep their shapes
/// @returns std::nullopt if the views do not determine these bends and the intrinsics
[[nodiscard]] std::optional<ShapeInformation> shapeInformation(const Fit& fit,
                                                               const std::vector<std::size_t>& boards = {0});

}  // namespace alidade
