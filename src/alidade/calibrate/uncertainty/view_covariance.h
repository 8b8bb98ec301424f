// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// Covariance of the intrinsics that takes only views for independent of each other, whatever the corners of
/// one view have in common (a moving board, blur): the sum of g g^T over the views between two inverses of
/// the slope times the information, g being the pull of one view on what is free (Liang and Zeger 1986,
/// Longitudinal data analysis using generalized linear models, Biometrika 73(1), the empirical covariance).
///
/// In small samples see ViewShares.
///
/// What is wrong in the same way in all views (a bent board held flat) shows only as far as it pulls
/// different views differently: see `common_error`, which is left empty here.
///
/// @param pulls       one a place (placesOf()), at the optimum; columns as the rows of `directions`
/// @param directions  what is free, one direction a column; the first `num_params` rows are the intrinsics
/// @param variance    of the coordinate of a corner of weight 1, px^2, see coordinateVariance()
/// @param mean_slope  see meanSlope()
/// @returns nothing where the views do not determine what is free, where nothing is, or where there are less
/// than three of them
[[nodiscard]] std::optional<ViewCovariance> viewCovariance(std::span<const Reduced> pulls,
                                                           const Eigen::MatrixXd& directions, int num_params,
                                                           double variance, double mean_slope);

}  // namespace alidade
