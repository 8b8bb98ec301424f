// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"
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
    const Eigen::Vector3d& p = board->corner(rows.corner.id);
    const Eigen::Vector2d profile = bendProfile(*board, p.x(), p.y());
    // A shift of the board along its own z is a shift of the point.
    const double J_px_z = rows.J_px_pose[static_cast<std::size_t>(axis)][2];
    return {.column = {first, first + 1}, .value = {J_px_z * profile.x(), J_px_z * profile.y()}};
  }
};

/// bend_x and bend_y of a board, then the offset of each of its points, for the views of this board.
struct OffsetColumns {
  const Board& board;

  [[nodiscard]] int size() const { return kNumBends + 3 * board.numCorners(); }
  [[nodiscard]] ExtraElements<kNumBends + 3> elements(const CornerRows& rows, int axis) const {
    const auto bends = BendColumns{.board = &board}.elements(rows, axis);
    const double* J_px_point = rows.J_px_pose[static_cast<std::size_t>(axis)];  // as a shift of the board
    const int point = kNumBends + 3 * rows.corner.id;
    return {.column = {0, 1, point, point + 1, point + 2},
            .value = {bends.value[0], bends.value[1], J_px_point[0], J_px_point[1], J_px_point[2]}};
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
