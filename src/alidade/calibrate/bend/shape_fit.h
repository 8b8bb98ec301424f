// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/adjust/noise/shape_information.h"
#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/calibrate/start/reports.h"

namespace alidade {

/// Hotelling's T^2 of the bend (1931, The generalization of Student's ratio), with its covariance between
/// views while intrinsics and poses follow. Degrees of freedom allow for views of unequal information:
/// Pustejovsky and Tipton 2018, Small-sample methods for cluster-robust variance estimation and hypothesis
/// testing in fixed effects models, Journal of Business and Economic Statistics 36(4), section 3.2; the
/// smaller value of those for bend_x and bend_y.
/// @param bend_m      bend_x and bend_y of the board at which `information` was computed
/// @param directions  see freeDirections()
/// @param mean_slope  see meanSlope()
/// @param which       index of the board among those of `information`
/// @returns nothing if there are too few views
[[nodiscard]] std::optional<BendByViews> bendByViews(const ShapeInformation& information,
                                                     const Eigen::Vector2d& bend_m,
                                                     const Eigen::MatrixXd& directions, double mean_slope,
                                                     std::size_t which = 0);

/// F statistic (by corner noise) from which a board counts as bent. With independent noise alone, a flat
/// board exceeds it once in a thousand times.
inline constexpr double kBendF = 6.9;

/// True if a board is bent: both tests agree, or the noise test alone if there are too few views for the
/// other.
/// @param f  F statistic by the corners' noise
[[nodiscard]] bool isBent(double f, const std::optional<BendByViews>& by_views);

/// The boards whose shapes are estimated with everything else, indices into Fit::boards.
[[nodiscard]] std::vector<std::size_t> estimatedShapes(const Fit& fit);
/// True if any board's shape is estimated.
[[nodiscard]] bool isShapeEstimated(const Fit& fit);

/// Estimates the bends of the boards together with everything else, starting from the solution for flat
/// boards, if requested or, in automatic mode, if the tests detect a bend; see isBent(). Boards are tested
/// one at a time, given the bends already estimated. The most significant bend is added first, because a bend
/// that is missing from the fit makes other boards look bent.
/// @returns one for each board of the fit
[[nodiscard]] std::vector<ShapeReport> estimateBends(SettledFit& now, BoardShapeMode mode,
                                                     const CancelFlag* cancel);

/// Tests each estimated bend again on the corners now in use, against a flat board on the same corners. If
/// the bend is no longer significant, the board is taken as flat, and outliers must be judged again.
void testBendsAgain(SettledFit& now, std::vector<ShapeReport>& reports, BoardShapeMode mode,
                    const CancelFlag* cancel);

/// Bends that the user excluded by asking for flat boards although the tests detect them, and their effect on
/// the parameters.
[[nodiscard]] std::optional<IgnoredBend> ignoredBend(const Fit& fit);

/// Estimates the offsets of the points of all boards (withOffsets()) if requested or, in automatic mode, if
/// they lower the held-out RMS significantly and by more than 5 %: an offset that predicts the corners of
/// other views belongs to the board and not to noise or to a lens beyond its model. A larger lens model that
/// leaves smaller errors takes precedence, and offsets that are mainly a stretch, grading or twist of the
/// whole board are left to the tests for these (CommonError). Boards of more than 400 points are not tested,
/// because the cost of the equations grows with the cube.
/// @param now     with the bends estimated
/// @param jobs    threads of the cross-validation
/// @param choice  gets the result of the test
void estimateOffsets(SettledFit& now, BoardShapeMode mode, int jobs, const CancelFlag* cancel,
                     Choice& choice);

/// Estimates the offsets again on the corners now in use.
void estimateOffsetsAgain(SettledFit& now, const CancelFlag* cancel);

}  // namespace alidade
