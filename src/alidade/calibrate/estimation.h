// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/calibrate/calibration_result.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/corner_noise.h"
#include "alidade/calibrate/param_constraint.h"

namespace alidade {

using Observations = std::vector<std::vector<Observation>>;  ///< a list a view
using Errors = std::vector<std::vector<Eigen::Vector2d>>;

/// What the steps of a calibration hand on to one another.
struct Estimation {
  Estimation(const Checkerboard& board_in, std::vector<View> views_in, const CalibratorOptions& options_in);

  const Checkerboard& board;
  const CalibratorOptions& options;
  ParamConstraint constraint;
  std::vector<View> views;    ///< in use, with all their corners
  Observations observations;  ///< of the corners in use
  Errors errors;              ///< of the same, by solve()
  CornerNoise noise;
  BundleState state;
  std::vector<BundleState> rivals;  ///< other optima of the start, until they are compared
  /// Parameters of those that were about as good on all views, for otherOptima().
  std::vector<std::vector<double>> close_params;
  HuberLoss loss{.threshold_px = 0};
  BundleSummary summary;
  StartReport start_report;
  ShapeReport shape;
  WeakPrior weak_prior;
  bool is_settled = false;
  std::vector<RepeatedView> repeated;
  std::vector<Outlier> outliers;
  std::vector<View> misfits;           ///< out of use because they do not fit, in order of image name
  std::vector<ExcludedView> excluded;  ///< out of use for other reasons, and misfits once these have one
};

/// Solves for intrinsics and poses from where they are and takes the errors.
void solve(Estimation& estimation, double function_tolerance = BundleOptions().function_tolerance);

/// Gives each corner its weight; the largest relative change of one.
double weigh(const CornerNoise& noise, Observations& views);

/// Errors of the corners in use times the roots of their weights, view by view.
[[nodiscard]] std::vector<Eigen::Vector2d> weightedErrors(const Estimation& estimation);

/// Mean over the corners in use of weight (dx^2 + dy^2), px^2.
[[nodiscard]] double meanWeightedSquare(const Estimation& estimation);

/// Root of the same for any camera and its poses, px.
[[nodiscard]] double weightedRms(std::string_view model_id, const Observations& views,
                                 const BundleState& state);

/// Puts a view that does not fit aside.
void setAside(Estimation& estimation, std::size_t view);

/// Takes a view out of use for good.
void exclude(Estimation& estimation, std::size_t view, std::string reason);

/// @throws Error (kInput) with the reasons of the views left out if fewer than kMinViews are in use
void requireViews(const Estimation& estimation);

}  // namespace alidade
