// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// The normal equations of each view with CommonColumns and the loss's weights, for the functions below.
[[nodiscard]] std::vector<Reduced> viewScores(const Fit& fit);

/// Estimates of the common errors, to first order (one Gauss-Newton step with intrinsics and poses free). One
/// cause may look like several: the most significant is included in the estimates of the others, then the
/// next, until no other is significant. The sigma is the larger of that by corner noise and that by the
/// disagreement of the views (White 1980, A heteroskedasticity-consistent covariance matrix estimator, by
/// view), which a lens that does not follow its model increases. Omits errors that the views do not
/// determine.
/// @param scores  see viewScores()
/// @param directions  free directions of the intrinsics, see freeDirections()
/// @param flexible  the same for a flexibleFit() of a stiff model, whose deviations from the lens would look
/// like one of these errors; empty for other models
/// @param variance  of the coordinate of a corner of weight 1, px^2
/// @param smoothness  total errors over those that neighbours do not share, at least 1. A lens that deviates
/// from its model causes the same errors in all views, which then agree, so the sigma is multiplied by this
[[nodiscard]] std::vector<CommonError> commonErrors(std::span<const Reduced> scores,
                                                    const Eigen::MatrixXd& directions,
                                                    std::span<const Reduced> flexible, double variance,
                                                    double smoothness);

/// One per view (Cook 1977, Detection of influential observation in linear regression, for blocks). Empty if
/// the views do not determine the intrinsics. Nothing contradicts a direction that only one view determines.
[[nodiscard]] std::vector<ViewInfluence> viewInfluences(std::span<const Reduced> scores,
                                                        const Eigen::MatrixXd& directions, double variance);

}  // namespace alidade
