// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/adjust/shape_information.h"

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
/// @param bend_m      bend_x and bend_y where `information` says what is left to pull
/// @param directions  see freeDirections()
/// @param mean_slope  see meanSlope()
/// @returns nothing where the views are too few to say
[[nodiscard]] std::optional<BendByViews> bendByViews(const ShapeInformation& information,
                                                     const Eigen::Vector2d& bend_m,
                                                     const Eigen::MatrixXd& directions, double mean_slope);

/// F statistic from which a board counts as bent by the corners' noise. A flat one exceeds it once in a
/// thousand times where there is nothing else.
inline constexpr double kBendF = 6.9;

/// Whether a board is bent: both tests must say so, or that by noise where the views are too few.
/// @param f  F statistic by the corners' noise
[[nodiscard]] bool isBent(double f, const std::optional<BendByViews>& by_views);

}  // namespace alidade
