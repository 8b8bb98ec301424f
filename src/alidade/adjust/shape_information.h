// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/reduced.h"
#include "alidade/target/board_shape.h"

namespace alidade {

/// Number of columns for BoardShape, after those of the intrinsics.
inline constexpr int kNumBends = 2;

/// bend_x and bend_y of the board's shape as further columns.
struct BendColumns {
  Board board;

  static int size() { return kNumBends; }
  [[nodiscard]] ExtraElements<kNumBends> elements(const CornerRows& rows, int axis) const {
    const Eigen::Vector2d profile = bendProfile(board, rows.corner.p_board.x(), rows.corner.p_board.y());
    // A shift of the board along its own z is a shift of the point.
    const double J_px_z = rows.J_px_pose[static_cast<std::size_t>(axis)][2];
    return {.column = {0, 1}, .value = {J_px_z * profile.x(), J_px_z * profile.y()}};
  }
};

/// The information of the corners about the bend of the board (BoardShape) at a solution, with poses and
/// intrinsics refitted for every change of the bend.
struct ShapeInformation {
  Eigen::Vector2d step_m;       ///< the change of the bend to the minimum of a parabola
  Eigen::VectorXd params_step;  ///< the change of the intrinsics with it
  double drop = 0;              ///< of twice the cost by this step, px^2 of a corner of weight 1
  /// (J^T W J)^-1 restricted to the bend, m^2 / px^2, and to the intrinsics, with bend and poses free.
  /// Multiplied by the variance of a corner of weight 1, they are covariances.
  Eigen::Matrix2d bend_inverse;
  Eigen::MatrixXd params_inverse;
  /// The information of each place, see placesOf(), at the end of the step, without the weights of the loss.
  std::vector<Reduced> pulls;
  Eigen::MatrixXd prior;  ///< the prior information, per px^2, with rows like those of the pulls
};

/// Free directions of the intrinsics, see freeDirections(), followed by the two of the bend.
[[nodiscard]] Eigen::MatrixXd withBend(const Eigen::MatrixXd& directions);

/// @param fit  of one camera and one board, at the optimum for the board's present shape
/// @returns std::nullopt if the views do not determine bend and intrinsics
[[nodiscard]] std::optional<ShapeInformation> shapeInformation(const Fit& fit);

}  // namespace alidade
