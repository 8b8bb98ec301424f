// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/robust_weighting.h"
#include "alidade/calibrate/bend/bend_by_views.h"
#include "alidade/calibrate/start/options.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// A bend of the board that the views show and the fit has left out, and the change of the parameters that it
/// would make, to first order.
struct IgnoredBend {
  BoardShape shape;
  DenseMatrix params_step;  ///< N x 1
  double cost_share = 1;    ///< of the corners' cost, what the bend would leave
  /// N x N: the covariance by the corners' noise of the camera with the bend.
  std::optional<DenseMatrix> covariance = {};
};

/// What the views say of the board's shape. The shape itself is the fit's.
struct ShapeReport {
  bool is_requested = false;  ///< whether or not a test sees a bend
  bool is_determined = true;  ///< false: these views and this board cannot tell a bend
  /// F statistic of the bend against a flat board, about 1 for a flat one; NaN if nobody asked.
  double f = std::numeric_limits<double>::quiet_NaN();
  std::optional<BendByViews> by_views;  ///< the same by views; nothing if nobody asked or they are too few
  /// One sigma of bend_x and bend_y, or with the board held flat what it would be; NaN if unknown.
  Eigen::Vector2d std_m = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  /// Where it was estimated: the camera that the same corners give under the same loss with the board held
  /// flat.
  std::vector<double> flat_params;
  double flat_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< and its weighted RMS
};

/// Whether the board's shape is estimated with everything else.
[[nodiscard]] bool isShapeEstimated(const Fit& fit);

struct BentFit {
  SettledFit settled;
  ShapeReport report;
};

/// Estimates the bend of the board together with everything else, from the solution for a flat one, if it is
/// asked for and, when that is left open, the tests say that the board is bent, see isBent().
[[nodiscard]] BentFit bent(SettledFit flat, BoardShapeMode mode, const CancelFlag* cancel);

/// Looks at the bend again on the corners now in use, if it is estimated at all, and compares with a flat
/// board on the same corners. Where those speak of a bend no more, the board is taken as flat, and what is an
/// outlier is to be judged anew.
[[nodiscard]] BentFit bendTestedAgain(BentFit bent, BoardShapeMode mode, const CancelFlag* cancel);

/// Where the board is held flat by the user's wish, looks whether it is bent all the same, and what that does
/// to the parameters.
[[nodiscard]] std::optional<IgnoredBend> ignoredBend(const Fit& fit);

}  // namespace alidade
