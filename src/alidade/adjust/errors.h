// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/fit.h"

namespace alidade {

/// Errors (projected minus observed, px, not weighted) of all corners of a view, from where their p_board
/// says that they are; NaN where a corner cannot be projected.
[[nodiscard]] std::vector<Eigen::Vector2d> reprojectionErrors(std::string_view model_id,
                                                              std::span<const double> params,
                                                              const SE3& camera_from_board,
                                                              std::span<const Observation> corners);

/// Of a view where the fit is.
[[nodiscard]] std::vector<Eigen::Vector2d> viewErrors(const Fit& fit, const FitView& view);

/// Half the sum of rho, as the solver counts it; NaN if a corner does not project.
[[nodiscard]] double viewCost(std::string_view model_id, std::span<const double> params, const SE3& pose,
                              std::span<const Observation> corners, HuberLoss loss);

// The rest reads FitView::errors.

/// Errors times the roots of their weights, view by view.
[[nodiscard]] std::vector<Eigen::Vector2d> weightedErrors(const Fit& fit);

/// Sum over all corners of weight (dx^2 + dy^2) over their number, px^2.
[[nodiscard]] double meanWeightedSquare(const Fit& fit);

/// Root of the same, px.
[[nodiscard]] double weightedRms(const Fit& fit);

/// sqrt(mean over all corners of dx^2 + dy^2), px.
[[nodiscard]] double rms(const Fit& fit);

}  // namespace alidade
