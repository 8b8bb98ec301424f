// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// From so many normal deviates on, views disagree by more than the corners' noise makes them: of clean sets
/// about 1 in 100 exceeds it.
inline constexpr double kBeyondChance = 3;

/// What the views' disagreement says of the intrinsics' uncertainty.
struct ViewCovariance {
  DenseMatrix covariance;  ///< N x N, parameters in storage order; not to be used where pooled
  /// Degrees of freedom of each parameter's variance: it is a multiple of chi square, roughly, and the
  /// parameter's error over its root follows Student's t. 0 for a parameter that is held.
  std::vector<double> freedom;
  /// Variance by this covariance over that by the corners' noise, averaged over the free directions in which
  /// the latter is 1; about 1 where there is nothing but independent noise.
  double excess = 0;
  /// The same in standard deviations of a normal variable: how surely it is more than chance.
  double excess_sigmas = 0;

  /// The views are too few for a covariance of their own: no more than there are free directions, or with
  /// less than two degrees of freedom for some parameter. Then the mean over all directions, `excess`,
  /// steadies each.
  bool is_pooled = false;

  /// N x N: in every direction the larger of the covariance by the corners' noise and of this one, the latter
  /// made larger for its few degrees of freedom (the least of a free parameter), so that 1.96 of its standard
  /// deviations hold 95 %. Pooled, it is in every direction the larger of the covariance by noise times the
  /// excess (above 1, and made larger for the number of views that say equally much, less one) and of this
  /// one, made larger as for two degrees of freedom; 95 % is then held on average over directions.
  DenseMatrix larger;

  /// N x 1: an error that all views have in common and that is known, which no disagreement shows (a bend of
  /// the board that was ignored); empty: none. Not in `covariance` and `larger`.
  DenseMatrix common_error = {};

  /// Half the width of parameter i's 95 % interval over 1.96: one standard deviation that can be used like
  /// one of a normal variable, together with the root mean square of the common error. 0 for a parameter that
  /// is held.
  [[nodiscard]] double effectiveStd(int i) const;
};

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
