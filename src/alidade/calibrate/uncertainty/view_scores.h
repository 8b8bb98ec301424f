// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/reduced.h"

namespace alidade {

/// The stretch of the board along its columns (x times 1 + stretch), as one further column.
struct StretchColumn {
  static int size() { return 1; }
  static ExtraElements<1> elements(const CornerRows& rows, int axis) {
    // The stretch moves the corner along the board's x, as a translation by x does.
    return {.column = {0},
            .value = {rows.J_px_pose[static_cast<std::size_t>(axis)][0] * rows.corner.p_board.x()}};
  }
};

/// How far squares are from square.
struct BoardStretch {
  double stretch = 0;  ///< width over height of the squares, less 1
  double sigma = 0;    ///< one standard deviation
};

/// The stretch that explains the corners best, to first order (one step of Gauss and Newton with intrinsics
/// and poses following). Its sigma is the larger of that by the corners' noise and that by how much the views
/// disagree (White 1980, A heteroskedasticity-consistent covariance matrix estimator, by view), which
/// a lens that does not follow its model raises. Nothing where the views do not determine it.
/// @param scores  one a view, with StretchColumn and the loss' weights
/// @param variance  of the coordinate of a corner of weight 1, px^2
/// @param directions  what is free among the intrinsics, see freeDirections()
[[nodiscard]] std::optional<BoardStretch> boardStretch(std::span<const Reduced> scores,
                                                       const Eigen::MatrixXd& directions, double variance);

/// What leaving out one view would do, to first order.
struct ViewInfluence {
  /// The most by which any function of the intrinsics would move, in standard deviations of its own: those by
  /// noise, or where the other views disagree with one another beyond chance, those by their disagreement if
  /// larger.
  double move_sigmas = 0;
  /// How much more the view disagrees with the others than noise makes views disagree, in standard deviations
  /// of a normal variable; at most 1 in 1000 views of a clean set exceeds 3.1. Where all views disagree
  /// because no lens of the model follows the real one, against what is typical among them.
  double surprise_sigmas = 0;
};

/// One a view (Cook 1977, Detection of influential observation in linear regression, for blocks). Empty where
/// the views do not determine the intrinsics. What a view determines all by itself, no other disagrees with.
[[nodiscard]] std::vector<ViewInfluence> viewInfluences(std::span<const Reduced> scores,
                                                        const Eigen::MatrixXd& directions, double variance);

}  // namespace alidade
