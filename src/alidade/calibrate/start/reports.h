// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/target/board_shape.h"

namespace alidade {

// Plain results of the stages start, clean, bend and choose, which users find in a Calibration.

/// Statistics of the search for a start.
struct StartReport {
  int num_tried = 0;   ///< fields of view at which the views could be explained at all
  int num_solved = 0;  ///< of these, the best: solved to convergence until two agreed or none was left
  int num_agreed = 0;  ///< of these, those that reached the optimum of the lowest cost
  int num_optima = 1;  ///< optima of about this cost from other shapes of the lens, including this one
};

/// A view that was given but not used.
struct ExcludedView {
  std::string image;
  std::size_t board = 0;  ///< see View
  std::string reason;
  bool is_misfit = false;  ///< does not fit the camera of the others
};

/// A view that was merged with another of the same pose, see mergeRepeatedViews().
struct RepeatedView {
  std::string image;
  std::size_t board = 0;  ///< see View
  std::string same_as;    ///< the image whose view stands for both
};

/// A corner left out of the estimate because it is far from its projection.
struct Outlier {
  std::size_t source = 0;  ///< see FitView
  std::string image;
  std::size_t board = 0;  ///< see View
  int corner_id = 0;
  Eigen::Vector2d pixel{0, 0};     ///< observed
  Eigen::Vector2d error_px{0, 0};  ///< projected minus observed
};

/// Given views and corners that are not in the fit.
struct Dropped {
  std::vector<ExcludedView> views;  ///< in order of image name and board
  std::vector<RepeatedView> repeated;
  std::vector<Outlier> outliers;  ///< of the views in use, in their order

  /// Number of views that do not fit the camera of the others.
  [[nodiscard]] std::size_t numMisfits() const {
    return static_cast<std::size_t>(std::ranges::count(views, true, &ExcludedView::is_misfit));
  }
  /// Share of the corners of the views in use that was left out.
  [[nodiscard]] double outlierShare(const Fit& fit) const {
    const auto num_out = static_cast<double>(outliers.size());
    return num_out / (num_out + static_cast<double>(numCorners(fit)));
  }
};

/// Agreement between views about a bend of the board. Noise alone makes bends significant too easily: an
/// error common to the corners of one view (blur, motion) counts there once per corner.
struct BendByViews {
  double f = 0;  ///< about 1 for a flat board: F(2, freedom - 1)
  double freedom =
      0;  ///< of the bend's covariance by views; the number of views less 1 if all are equally informative
  double chance = 0;            ///< probability of such an F or a larger one for a flat board
  Eigen::Vector2d std_m{0, 0};  ///< of bend_x and bend_y by views, 95 % of their errors being within 1.96
};

/// Bends that the views show and the fit ignores, and the first-order change of the parameters that including
/// them would cause.
struct IgnoredBend {
  std::vector<std::size_t> boards;  ///< bent boards, indices into Fit::boards
  std::vector<BoardShape> shapes;   ///< one for each of these
  DenseMatrix params_step;          ///< N x 1
  double cost_share = 1;            ///< share of the corners' cost that the bends would leave
  /// N x N covariance, by corner noise, of the camera with the bends.
  std::optional<DenseMatrix> covariance = {};
};

/// Evidence of the views about a board's shape. The shape itself is in the fit.
struct ShapeReport {
  bool is_requested = false;  ///< estimated whether or not a test detects a bend
  bool is_determined = true;  ///< false if these views and this board cannot show a bend
  /// F statistic of the bend against a flat board, about 1 for a flat one; NaN if it was not tested.
  double f = std::numeric_limits<double>::quiet_NaN();
  std::optional<BendByViews> by_views;  ///< the same by views; nothing if not tested or too few views
  /// One sigma of bend_x and bend_y; if the board is held flat, the value if it were estimated. NaN if
  /// unknown.
  Eigen::Vector2d std_m = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  /// If estimated: the camera from the same corners and loss with this board held flat.
  std::vector<double> flat_params;
  double flat_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< its weighted RMS
};

/// A model considered for the choice.
struct ModelCandidate {
  std::string id;
  int num_params = 0;
  double rms_px = std::numeric_limits<double>::quiet_NaN();  ///< weighted, on the corners in common
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// Excess of its held-out RMS over that of the best, as a share, with its standard error.
  double excess = std::numeric_limits<double>::quiet_NaN();
  double excess_std = std::numeric_limits<double>::quiet_NaN();
  /// chosen; worse; larger (no worse than the chosen one, but not needed); no_solution; not_allowed; or why
  /// it cannot be recommended, see Unsoundness: not_converged, ill_conditioned, corners_outside_domain,
  /// folds_in_image, no_holdout. `rejected`: calibrated with it, a diagnosis is a failure.
  std::string verdict;
  std::string reason;  ///< the same for human readers
};

/// How a model was chosen.
struct ModelChoice {
  std::vector<ModelCandidate> candidates;  ///< by number of parameters
  std::string best;                        ///< the one with the lowest held-out error
  std::string reference;                   ///< the one that decided which corners are outliers
  /// Angle between the rays of the midpoints of the image's shorter sides, radians; infinite if these have
  /// none.
  double field_rad = 0;
  bool is_wide = false;  ///< fisheye models were considered
};

/// A correction field, and its reasons.
struct CorrectionReport {
  double rms_px = 0;    ///< of the displacements, sqrt(mean over the corners of dx^2 + dy^2)
  double worst_px = 0;  ///< the largest of them
  std::optional<HeldOutExcess> excess = {};  ///< of held-out errors without it; nothing if it was requested
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< with the field from other views only
};

/// Decisions made during a fit.
struct Choice {
  StartReport start = {};
  std::vector<ShapeReport> shapes = {};  ///< one for each board of the fit
  /// Excess of held-out errors without offsets; nothing if not tested or if the errors of the fit settled it.
  std::optional<HeldOutExcess> even_excess = {};
  /// True if offsets were requested, but the views show none beyond noise.
  bool are_offsets_undetermined = false;
  /// Excess of held-out errors without the last number of the entrance pupil; nothing if not tested.
  std::optional<HeldOutExcess> pupil_excess = {};
  /// True if an entrance pupil was requested, but the views do not determine the lens itself.
  bool is_pupil_undetermined = false;
  /// How a correction field was chosen; nothing if the lens needs none, or none was wanted.
  std::optional<CorrectionReport> correction = {};
  /// True if a correction field was requested, but the views show none beyond noise.
  bool is_correction_undetermined = false;
  bool is_settled = false;                ///< noise estimate and outliers converged within the allowed rounds
  std::optional<ModelChoice> model = {};  ///< if the model was not named
  std::optional<BetterModel> better_model = {};  ///< if it was named
};

}  // namespace alidade
