// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// Covariance of the intrinsics that assumes only that views are independent of each other, while the corners
/// of one view may share errors (a moving board, blur): the sum of g g^T over the views between two inverses
/// of the slope times the information, where g is the pull of one view on the free directions (Liang and
/// Zeger 1986, Longitudinal data analysis using generalized linear models, Biometrika 73(1), the empirical
/// covariance).
///
/// For small samples see ViewShares.
///
/// An error that is the same in all views (a bent board held flat) shows only as far as it pulls different
/// views differently: see `common_error`, which is left empty here.
///
/// @param pulls       one per place (placesOf()), at the optimum; columns as the rows of `directions`
/// @param directions  free directions, one per column; the first `num_params` rows are the intrinsics
/// @param variance    of the coordinate of a corner of weight 1, px^2, see coordinateVariance()
/// @param mean_slope  see meanSlope()
/// @returns nothing if the views do not determine the free directions, if there are none, or if there are
/// fewer than three views
[[nodiscard]] std::optional<ViewCovariance> viewCovariance(std::span<const Reduced> pulls,
                                                           const Eigen::MatrixXd& directions, int num_params,
                                                           double variance, double mean_slope);

}  // namespace alidade
