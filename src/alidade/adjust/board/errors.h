// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/target/board.h"

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

/// sqrt(mean over all corners of weight (dx^2 + dy^2)), px.
[[nodiscard]] double weightedRms(const Fit& fit);

/// sqrt(mean over all corners of dx^2 + dy^2), px.
[[nodiscard]] double rms(const Fit& fit);

/// Standard deviation of the coordinate of a corner of weight 1, px, from the differences of the errors of
/// corners that are neighbours on the board (von Neumann 1941, Distribution of the ratio of the mean square
/// successive difference to the variance). Noise that is independent from corner to corner gives the same as
/// the errors themselves; errors that vary smoothly give much less. NaN if no two neighbours were seen.
[[nodiscard]] double localSigma(const Fit& fit);

/// Sums for localSigma() over some views.
class NeighbourDifferences {
 public:
  /// @param board   of the view
  /// @param errors  one per corner, px, not weighted
  void add(const Board& board, std::span<const Observation> corners, std::span<const Eigen::Vector2d> errors);
  [[nodiscard]] double sigma() const;

 private:
  std::vector<int> index_of_;
  double sum_ = 0;
  int num_pairs_ = 0;
};

}  // namespace alidade
