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
/// @param is_series  the pulls are in succession, so that neighbours may be alike, see serialFactor(); not if
/// several are of one image
/// @returns nothing if the views do not determine the free directions, if there are none, or if there are
/// fewer than three views
[[nodiscard]] std::optional<ViewCovariance> viewCovariance(std::span<const Reduced> pulls,
                                                           const Eigen::MatrixXd& directions, int num_params,
                                                           double variance, double mean_slope,
                                                           bool is_series = true);

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
/// @param camera  that of the fit; each of its held values is freed as a cause of its own, unless all are
/// held
/// @param flexible  the same for a flexibleFit() of a stiff model, whose deviations from the lens would look
/// like one of these errors; empty for other models
/// @param variance  of the coordinate of a corner of weight 1, px^2
/// @param smoothness  total errors over those that neighbours do not share, at least 1. A lens that deviates
/// from its model causes the same errors in all views, which then agree, so the sigma is multiplied by this
[[nodiscard]] std::vector<CommonError> commonErrors(std::span<const Reduced> scores,
                                                    const Eigen::MatrixXd& directions,
                                                    const FitCamera& camera,
                                                    std::span<const Reduced> flexible, double variance,
                                                    double smoothness);

/// One per view (Cook 1977, Detection of influential observation in linear regression, for blocks). Empty if
/// the views do not determine the intrinsics. Nothing contradicts a direction that only one view determines.
[[nodiscard]] std::vector<ViewInfluence> viewInfluences(std::span<const Reduced> scores,
                                                        const Eigen::MatrixXd& directions, double variance);

/// Each view votes for a displacement field over the image, bilinear between the nodes of a coarse grid, by
/// the score of the field at zero with pose and intrinsics eliminated (Rao 1948, Large sample tests of
/// statistical hypotheses concerning several parameters). Otherwise, poses that adapt to the lens would hide
/// the common errors of the views.
/// @param fit  of one camera, solved
[[nodiscard]] ImageBias imageBias(const Fit& fit);

/// Tests whether the views fall into two groups, each with its own intrinsics. To first order each place of
/// the board (placesOf()) has an information and a gradient of the intrinsics. Two groups suggested by the
/// names are compared by an F test. Otherwise k-means in this metric finds two offsets and the places of
/// each. Along the line between the offsets, a mixture of two normal distributions is compared with a single
/// one of free width, because a lens that does not follow the model, a breathing focus or a moving board
/// causes continuous variation.
/// @param fit       of one camera, solved
/// @param variance  of the coordinate of a corner of weight 1, px^2
/// @returns std::nullopt without evidence for two groups of at least three places each
[[nodiscard]] std::optional<TwoCameras> twoCameras(const Fit& fit, double variance);

/// Looks for a step of the focal length from one view to the next. A common camera would be the mean of both
/// settings, and poses would hide most of the difference.
/// @param scores  as for viewInfluences(), in the order in which the views were taken
/// @returns nothing with fewer than ten views, with a held focal length, or with a weak prior
[[nodiscard]] std::optional<FocalStep> focalStep(std::span<const Reduced> scores,
                                                 const Eigen::MatrixXd& directions, const FitCamera& camera,
                                                 double variance);

/// Variation between views that one camera should not show.
/// @param fit  of one camera, solved
[[nodiscard]] ViewVariations viewVariations(const Fit& fit);

}  // namespace alidade
