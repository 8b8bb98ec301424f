// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// The normal equations of each view with CommonColumns and the loss' weights, for the functions below.
[[nodiscard]] std::vector<Reduced> viewScores(const Fit& fit);

/// Each of the errors that explains the corners best, to first order (one step of Gauss and Newton with
/// intrinsics and poses following). One cause may look like several: the most significant is taken into
/// account in the estimates of the others, then the next, until no other is significant. The sigma is the
/// larger of that by the corners' noise and that by how much the views disagree (White 1980, A
/// heteroskedasticity-consistent covariance matrix estimator, by view), which a lens that does not follow its
/// model raises. Without those that the views do not determine.
/// @param scores  see viewScores()
/// @param directions  what is free among the intrinsics, see freeDirections()
/// @param flexible  the same for a flexibleFit() of a stiff model, whose deviations from the lens would look
/// like one of these errors; empty for other models
/// @param variance  of the coordinate of a corner of weight 1, px^2
/// @param smoothness  the errors over those that neighbours do not share, at least 1: a lens that deviates
/// from its model errs alike in all views, so that they agree on it; the sigma is larger by this
[[nodiscard]] std::vector<CommonError> commonErrors(std::span<const Reduced> scores,
                                                    const Eigen::MatrixXd& directions,
                                                    std::span<const Reduced> flexible, double variance,
                                                    double smoothness);

/// One a view (Cook 1977, Detection of influential observation in linear regression, for blocks). Empty where
/// the views do not determine the intrinsics. Nothing contradicts a direction that only one view determines.
[[nodiscard]] std::vector<ViewInfluence> viewInfluences(std::span<const Reduced> scores,
                                                        const Eigen::MatrixXd& directions, double variance);

}  // namespace alidade
