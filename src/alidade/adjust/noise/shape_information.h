// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"

namespace alidade {

/// The information of the corners about the bends of boards (BoardShape) at a solution, with poses and
/// intrinsics refitted for every change of a bend. The columns of the bends are bend_x and bend_y of each
/// board in turn.
struct ShapeInformation {
  std::vector<std::size_t> boards;  ///< boards with free bends; indices into Fit::boards
  Eigen::VectorXd step_m;           ///< the change of the bends to the minimum of the quadratic model
  Eigen::VectorXd params_step;      ///< the corresponding change of the intrinsics
  double drop = 0;                  ///< decrease of twice the cost by this step, px^2 of a corner of weight 1
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
