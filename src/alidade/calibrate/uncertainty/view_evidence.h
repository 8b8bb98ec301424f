// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
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

/// Each view votes for a displacement field over the image, bilinear between the nodes of a coarse grid, by
/// the score of the field at zero with the pose and the intrinsics following (Rao 1948, Large sample tests of
/// statistical hypotheses concerning several parameters). Without that, poses that give way to the lens
/// would hide what the views have in common.
/// @param fit  of one camera, solved
[[nodiscard]] ImageBias imageBias(const Fit& fit);

/// Tests whether the views fall into two groups, each with its own intrinsics. To first order each place of
/// the board (placesOf()) gives an information and a gradient of the intrinsics. Two groups that the names
/// suggest are compared by an F test. Otherwise k-means in this metric finds two offsets and the places of
/// each, and along the line between the offsets a mixture of two normal distributions is compared with a
/// single one, whose width is free: a lens that does not follow the model, a focus that breathes or a moving
/// board vary continuously.
/// @param fit       of one camera, solved
/// @param variance  of the coordinate of a corner of weight 1, px^2
/// @returns std::nullopt if nothing speaks for two groups of at least three places each
[[nodiscard]] std::optional<TwoCameras> twoCameras(const Fit& fit, double variance);

/// What differs from view to view although it should not.
/// @param fit  of one camera, solved
[[nodiscard]] ViewVariations viewVariations(const Fit& fit);

}  // namespace alidade
