// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Errors of corners that were not used to estimate the camera or the pose that projects them.
struct HeldOutErrors {
  int num_folds = 0;
  /// Projected minus observed, px, not weighted, in the order of the views' corners; NaN if a corner does not
  /// project with the camera from the other views. A view has no errors if its corners do not give two poses.
  std::vector<std::vector<Eigen::Vector2d>> px;
};

/// A view's corners by the colour of their squares, as indices into the view: both halves span the board.
using CornerHalves = std::array<std::vector<std::size_t>, 2>;
[[nodiscard]] CornerHalves halvesOf(const Board& board, std::span<const Observation> view);

/// True if corners determine a pose: at least four that are not nearly on one line.
[[nodiscard]] bool givesPose(std::span<const Observation> corners);

/// A change of the corners before one fold is left out.
using FoldChange = std::function<void(int fold, Fit& fit)>;

/// Cross-validation over views. Each fold of views is left out in turn, and intrinsics and poses are
/// estimated again from the other views, starting at the full solution with its weights and loss. Each
/// held-out view then gets a pose from one half of its corners and errors on the other half, and vice versa:
/// the two colours of a checkerboard, (column + row) even and odd, which both span the board.
///
/// Returns std::nullopt if the other views do not determine a camera.
/// @param fit  the solution for all views, of one camera; the bends of the boards are not estimated again,
/// but the offsets are
/// @param jobs  threads; 0: one per processor. The result does not depend on it.
[[nodiscard]] std::optional<HeldOutErrors> heldOutErrors(const Fit& fit, int jobs = 1,
                                                         const CancelFlag* cancel = nullptr,
                                                         const FoldChange& change = {});

/// The fold of view v of num_views in order of name, from 0 to numFolds() - 1.
///
/// Each fold consists of four runs of consecutive views, one from each quarter of the sequence (with fewer
/// than 20 views, single views). Neighbouring frames of a video are nearly the same: in different folds, a
/// near-copy of each held-out view would take part in the fit. If a fold were a single run, the other views
/// might not cover the same part of the image.
[[nodiscard]] int foldOf(std::size_t v, std::size_t num_views);
[[nodiscard]] int numFolds(std::size_t num_views);

/// The result of cross-validation.
struct HoldoutReport {
  double rms_px = std::numeric_limits<double>::quiet_NaN();  ///< sqrt(mean of dx^2 + dy^2); NaN if unknown
  int num_folds = 0;    ///< 0: the views of the other folds do not determine a camera
  int num_corners = 0;  ///< with a cross-validation error
  int num_unseen = 0;   ///< corners not seen by the camera of the other views
};

[[nodiscard]] HoldoutReport holdoutReport(const std::optional<HeldOutErrors>& errors);

/// Held-out errors per view, for comparisons.
struct HeldOutScore {
  std::vector<double> of_view;  ///< sum of rho over a view's corners, px^2 of a corner of weight 1
  double sum = 0;               ///< over all views
};

/// The contribution of a corner that does not project, as if its error were ten thresholds of the loss.
[[nodiscard]] double farOff(HuberLoss loss);

/// Added to the sum of squares of this many corners, so that rounding does not decide if they fit perfectly:
/// no corner is better than kMinSigmaPx.
[[nodiscard]] double noiseFloor(std::size_t num_corners);

/// A corner that does not project counts as farOff().
/// @param fit  of the same corners
[[nodiscard]] HeldOutScore scoreOf(const HeldOutErrors& errors, const Fit& fit);

/// Excess of one model's held-out errors over another's on the same corners.
struct HeldOutExcess {
  double share = 0;             ///< as a share of the other's held-out RMS; negative if they are smaller
  double std = 0;               ///< its standard error, from the spread over views
  bool is_significant = false;  ///< see excessOf()
  double proven_share = 0;      ///< significant part of the share, for isWorth()

  /// True if the excess is significant and large enough to justify this many further parameters.
  [[nodiscard]] bool isWorth(std::size_t num_further_params) const;
};

/// The paired comparison of two models view by view: corners of one view share its pose and its errors, so
/// only views are independent. The excess is significant if either the difference of the views' sums of
/// squares or the factor between them exceeds chance in 19 of 20 cases (one-sided; either does so by chance
/// in about 1 of 15). The factor helps if a model misses the lens by pixels: one view may then dominate the
/// sum, so that the mean difference is not significant although all views agree. The factors prove no more
/// than their mean.
/// @param a,b  of the same views and corners
[[nodiscard]] HeldOutExcess excessOf(const HeldOutScore& a, const HeldOutScore& b);

/// Least reduction of the held-out RMS that justifies a further parameter, as a share of it; see
/// docs/model_choice.md.
inline constexpr double kShareOfParameter = 0.005;

/// A model with more parameters that explains the same views significantly better.
struct BetterModel {
  std::string id;
  double rms_px = 0;       ///< weighted, with the weights of the model in use
  double lean_rms_px = 0;  ///< the same for the model in use
  std::vector<double> params = {};
};

}  // namespace alidade
