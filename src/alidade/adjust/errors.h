// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/fit.h"

namespace alidade {

/// Errors (projected minus observed, px, not weighted) of all corners of a view, whose board positions are
/// p_board; NaN if a corner cannot be projected.
[[nodiscard]] std::vector<Eigen::Vector2d> reprojectionErrors(std::string_view model_id,
                                                              std::span<const double> params,
                                                              const SE3& camera_from_board,
                                                              std::span<const Observation> corners);

/// The same for a view of a fit, at its current parameters and poses.
[[nodiscard]] std::vector<Eigen::Vector2d> viewErrors(const Fit& fit, const FitView& view);

/// Half the sum of rho, like the cost of the solver; NaN if a corner does not project.
[[nodiscard]] double viewCost(std::string_view model_id, std::span<const double> params, const SE3& pose,
                              std::span<const Observation> corners, HuberLoss loss);

// The functions below use FitView::errors.

/// Errors times the square roots of their weights, view by view.
[[nodiscard]] std::vector<Eigen::Vector2d> weightedErrors(const Fit& fit);

/// Mean over all corners of weight (dx^2 + dy^2), px^2.
[[nodiscard]] double meanWeightedSquare(const Fit& fit);

/// The square root of meanWeightedSquare(), px.
[[nodiscard]] double weightedRms(const Fit& fit);

/// sqrt(mean over all corners of dx^2 + dy^2), px.
[[nodiscard]] double rms(const Fit& fit);

}  // namespace alidade
