// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/fit.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Errors of corners that were not used to estimate the camera or the pose that projects them.
struct HeldOutErrors {
  int num_folds = 0;
  /// Projected minus observed, px, not weighted, in the order of the views' corners; NaN for a corner that
  /// the camera of the other views does not see. A view has no errors if its corners do not give two poses.
  std::vector<std::vector<Eigen::Vector2d>> px;
};

/// Cross-validation over views. Each fold of views is left out in turn, and intrinsics and poses are
/// estimated again from the other views, starting at the full solution with its weights and loss. Each
/// held-out view then gets a pose from one half of its corners and errors on the other half, and vice versa:
/// the two colours of a checkerboard, (column + row) even and odd, which both span the board.
///
/// Returns std::nullopt if the other views do not determine a camera.
/// @param fit  the solution for all views, of one camera and one board; the board's shape is not estimated
///             again
[[nodiscard]] std::optional<HeldOutErrors> heldOutErrors(const Fit& fit, const CancelFlag* cancel = nullptr);

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
  int num_folds = 0;    ///< 0: the views of the other folds give no camera
  int num_corners = 0;  ///< with a cross-validation error
  int num_unseen = 0;   ///< corners not seen by the camera of the other views
};

[[nodiscard]] HoldoutReport holdoutReport(const std::optional<HeldOutErrors>& errors);

}  // namespace alidade
