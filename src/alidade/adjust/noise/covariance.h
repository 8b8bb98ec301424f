// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// The inverse of a symmetric matrix, with its condition.
struct ScaledInverse {
  /// Ratio of the smallest to the largest eigenvalue after scaling the diagonal to 1, at least 0; 0 if an
  /// element of the diagonal is not positive.
  double condition = 0;
  std::optional<Eigen::MatrixXd> inverse;  ///< nothing if the matrix is singular to working precision
};

/// Scales the diagonal to 1 first, so that parameters of any unit compare.
/// @param singular  condition below which the smallest eigenvalue is rounding
[[nodiscard]] ScaledInverse scaledInverse(const Eigen::MatrixXd& matrix, double singular = 1e-13);

/// The same along free directions, one per column: the inverse is zero across them, and the condition is that
/// along them.
[[nodiscard]] ScaledInverse inverseAlong(const Eigen::MatrixXd& directions, const Eigen::MatrixXd& matrix);

/// Information of the corners on the intrinsics with every pose free; the inverse is along the directions
/// that the constraint leaves free. A condition near 0 means that these views do not determine some
/// combination of parameters.
struct IntrinsicsInformation : ScaledInverse {
  /// N x N: the Schur complement of the poses in J^T W J with the corners' weights W, so that covariance =
  /// sigma^2 * information^-1 with the variance sigma^2 of a corner of weight 1. Per px^2.
  Eigen::MatrixXd information;
};

/// The information of a fit of one camera; corners that do not project are left out.
[[nodiscard]] IntrinsicsInformation intrinsicsInformation(const Fit& fit);

/// Mean slope psi' of Huber's estimate over both axes of all corners: 1 if none exceeds the threshold.
/// @param weighted_errors  reprojection errors times the square root of the corners' weights, px
[[nodiscard]] double meanSlope(std::span<const Eigen::Vector2d> weighted_errors, HuberLoss loss);

/// Variance of one coordinate of a corner of weight 1, px^2, as it enters the covariance of a Huber estimate:
/// [sum psi^2 / (2 corners - free parameters)] / (mean psi')^2 (Huber 1981, Robust Statistics, section 7.6).
/// Without outliers it is the sum of squares over the degrees of freedom, counted per coordinate.
/// @param weighted_errors  reprojection errors times the square root of the corners' weights, px
[[nodiscard]] double coordinateVariance(std::span<const Eigen::Vector2d> weighted_errors, HuberLoss loss,
                                        double num_free_params);

}  // namespace alidade
