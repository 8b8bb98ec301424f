// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/adjust/noise/shape_information.h"
#include "alidade/calibrate/start/options.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// Whether the views agree that the board is bent. Noise alone makes a bend significant in no time: what the
/// corners of a view have in common (blur, motion) counts there as often as there are corners.
struct BendByViews {
  double f = 0;  ///< about 1 for a flat board: F(2, freedom - 1)
  double freedom =
      0;  ///< of the bend's covariance by views; the number of views less 1 if all say equally much
  double chance = 0;            ///< probability of such an F or a larger one for a flat board
  Eigen::Vector2d std_m{0, 0};  ///< of bend_x and bend_y by views, 95 % of their errors being within 1.96
};

/// Hotelling's T^2 of the bend (1931, The generalization of Student's ratio) with its covariance by views,
/// the intrinsics and the poses following, and with degrees of freedom for views that do not say equally
/// much: Pustejovsky and Tipton 2018, Small-sample methods for cluster-robust variance estimation and
/// hypothesis testing in fixed effects models, Journal of Business and Economic Statistics 36(4),
/// section 3.2; here those of the one of bend_x and bend_y that has fewer.
/// @param bend_m      bend_x and bend_y of the board where `information` says what is left to pull
/// @param directions  see freeDirections()
/// @param mean_slope  see meanSlope()
/// @param which       index of the board among those of `information`
/// @returns nothing where the views are too few to say
[[nodiscard]] std::optional<BendByViews> bendByViews(const ShapeInformation& information,
                                                     const Eigen::Vector2d& bend_m,
                                                     const Eigen::MatrixXd& directions, double mean_slope,
                                                     std::size_t which = 0);

/// F statistic from which a board counts as bent by the corners' noise. A flat one exceeds it once in a
/// thousand times where there is nothing else.
inline constexpr double kBendF = 6.9;

/// Whether a board is bent: both tests must say so, or that by noise where the views are too few.
/// @param f  F statistic by the corners' noise
[[nodiscard]] bool isBent(double f, const std::optional<BendByViews>& by_views);

/// Bends of boards that the views show and the fit has left out, and the change of the parameters that they
/// would make, to first order.
struct IgnoredBend {
  std::vector<std::size_t> boards;  ///< that are bent, indices into Fit::boards
  std::vector<BoardShape> shapes;   ///< one for each of these
  DenseMatrix params_step;          ///< N x 1
  double cost_share = 1;            ///< of the corners' cost, what the bends would leave
  /// N x N: the covariance by the corners' noise of the camera with the bends.
  std::optional<DenseMatrix> covariance = {};
};

/// What the views say of a board's shape. The shape itself is the fit's.
struct ShapeReport {
  bool is_requested = false;  ///< whether or not a test sees a bend
  bool is_determined = true;  ///< false: these views and this board cannot tell a bend
  /// F statistic of the bend against a flat board, about 1 for a flat one; NaN if nobody asked.
  double f = std::numeric_limits<double>::quiet_NaN();
  std::optional<BendByViews> by_views;  ///< the same by views; nothing if nobody asked or they are too few
  /// One sigma of bend_x and bend_y, or with the board held flat what it would be; NaN if unknown.
  Eigen::Vector2d std_m = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  /// Where it was estimated: the camera that the same corners give under the same loss with this board held
  /// flat.
  std::vector<double> flat_params;
  double flat_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< and its weighted RMS
};

/// The boards whose shapes are estimated with everything else, indices into Fit::boards.
[[nodiscard]] std::vector<std::size_t> estimatedShapes(const Fit& fit);
/// Whether there is any.
[[nodiscard]] bool isShapeEstimated(const Fit& fit);

struct BentFit {
  SettledFit settled;
  std::vector<ShapeReport> reports;  ///< one for each board of the fit
};

/// Estimates the bends of the boards together with everything else, from the solution for flat ones, if it is
/// asked for and, when that is left open, the tests say that a board is bent, see isBent(). Boards are tested
/// one by one, each beside those that are estimated already, and the most significant bend goes first: a
/// board whose bend is not in the fit makes others look bent.
[[nodiscard]] BentFit bent(SettledFit flat, BoardShapeMode mode, const CancelFlag* cancel);

/// Looks at each bend that is estimated again, on the corners now in use, and compares with a flat board on
/// the same corners. Where those speak of a bend no more, the board is taken as flat, and what is an outlier
/// is to be judged anew.
[[nodiscard]] BentFit bendTestedAgain(BentFit bent, BoardShapeMode mode, const CancelFlag* cancel);

/// Where the boards are held flat by the user's wish, looks which are bent all the same, and what that does
/// to the parameters.
[[nodiscard]] std::optional<IgnoredBend> ignoredBend(const Fit& fit);

}  // namespace alidade
