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

/// How the search for a start went.
struct StartReport {
  int num_tried = 0;   ///< fields of view at which the views could be explained at all
  int num_solved = 0;  ///< of these, the best, solved to convergence until two agreed or none was left
  int num_agreed = 0;  ///< of these, those that came to the optimum of the lowest cost
  int num_optima = 1;  ///< optima of about this cost that other shapes of the lens led to, this one with them
};

/// A view that was given but not used.
struct ExcludedView {
  std::string image;
  std::size_t board = 0;  ///< see View
  std::string reason;
  bool is_misfit = false;  ///< it does not fit the camera of the others
};

/// A view that was merged with another of the same pose, see mergeRepeatedViews().
struct RepeatedView {
  std::string image;
  std::size_t board = 0;  ///< see View
  std::string same_as;    ///< the image whose view stands for both
};

/// A corner left out of the estimate because it lies far from where the camera puts it.
struct Outlier {
  std::size_t source = 0;  ///< see FitView
  std::string image;
  std::size_t board = 0;  ///< see View
  int corner_id = 0;
  Eigen::Vector2d error_px{0, 0};  ///< projected minus observed
};

/// Given views and corners that are not in the fit.
struct Dropped {
  std::vector<ExcludedView> views;  ///< in order of image name and board
  std::vector<RepeatedView> repeated;
  std::vector<Outlier> outliers;  ///< of the views in use, in their order

  /// Of the views, those that do not fit the camera of the others.
  [[nodiscard]] std::size_t numMisfits() const {
    return static_cast<std::size_t>(std::ranges::count(views, true, &ExcludedView::is_misfit));
  }
  /// Of the corners of the views in use, the share that was left out.
  [[nodiscard]] double outlierShare(const Fit& fit) const {
    const auto num_out = static_cast<double>(outliers.size());
    return num_out / (num_out + static_cast<double>(numCorners(fit)));
  }
};

/// Whether the views agree that the board is bent. Noise alone makes a bend significant in no time: what the
/// corners of a view have in common (blur, motion) counts there as often as there are corners.
struct BendByViews {
  double f = 0;  ///< about 1 for a flat board: F(2, freedom - 1)
  double freedom =
      0;  ///< of the bend's covariance by views; the number of views less 1 if all say equally much
  double chance = 0;            ///< probability of such an F or a larger one for a flat board
  Eigen::Vector2d std_m{0, 0};  ///< of bend_x and bend_y by views, 95 % of their errors being within 1.96
};

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

/// Evidence of the views about a board's shape. The shape itself is in the fit.
struct ShapeReport {
  bool is_requested = false;  ///< whether or not a test sees a bend
  bool is_determined = true;  ///< false: these views and this board cannot tell a bend
  /// F statistic of the bend against a flat board, about 1 for a flat one; NaN if it was not tested.
  double f = std::numeric_limits<double>::quiet_NaN();
  std::optional<BendByViews> by_views;  ///< the same by views; nothing if not tested or too few
  /// One sigma of bend_x and bend_y, or with the board held flat what it would be; NaN if unknown.
  Eigen::Vector2d std_m = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  /// Where it was estimated: the camera that the same corners give under the same loss with this board held
  /// flat.
  std::vector<double> flat_params;
  double flat_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< and its weighted RMS
};

/// A model that was considered.
struct ModelCandidate {
  std::string id;
  int num_params = 0;
  double rms_px = std::numeric_limits<double>::quiet_NaN();  ///< weighted, on the corners in common
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// How much larger its held-out RMS is than that of the best, as a share, and the standard error of that.
  double excess = std::numeric_limits<double>::quiet_NaN();
  double excess_std = std::numeric_limits<double>::quiet_NaN();
  /// chosen; worse; larger (no worse than the chosen one, but not needed); no_solution; not_allowed; or why
  /// it is no camera to recommend, see Unsoundness: not_converged, ill_conditioned, corners_outside_domain,
  /// folds_in_image, no_holdout.
  std::string verdict;
  std::string reason;  ///< the same for people
};

/// How a model was chosen.
struct ModelChoice {
  std::vector<ModelCandidate> candidates;  ///< by number of parameters
  std::string best;                        ///< the one with the least held-out error
  std::string reference;                   ///< the one that decided which corners are outliers
  /// Angle between the rays of the middles of the image's shorter sides, radians; infinite where these have
  /// none.
  double field_rad = 0;
  bool is_wide = false;  ///< fisheye models were considered
};

/// Decisions on the way to a fit.
struct Choice {
  StartReport start = {};
  std::vector<ShapeReport> shapes = {};  ///< one for each board of the fit
  /// By how much held-out errors are larger with the points of the boards in their places; nothing where a
  /// glance at the errors was enough or it was not tested.
  std::optional<HeldOutExcess> even_excess = {};
  /// Offsets of the points were asked for, and the views show none that stand out from noise.
  bool are_offsets_undetermined = false;
  bool is_settled = false;  ///< noise estimate and set of outliers came to rest in the rounds allowed
  std::optional<ModelChoice> model = {};         ///< where the model was not named
  std::optional<BetterModel> better_model = {};  ///< where it was
};

}  // namespace alidade
