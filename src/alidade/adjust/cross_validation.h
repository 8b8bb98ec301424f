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

/// Errors of corners that had no part in the camera nor in the pose that they are projected with.
struct HeldOutErrors {
  int num_folds = 0;
  /// Projected minus observed, px, not weighted, in the order of the views' corners; NaN for a corner that
  /// the camera of the other views does not see. A view whose corners do not give two poses has none.
  std::vector<std::vector<Eigen::Vector2d>> px;
};

/// Cross-validation over views. The views of one fold after the other are left out, and intrinsics and the
/// poses of the rest solved again from the full solution, with its weights and loss. Each view that was left
/// out then gets a pose from one half of its corners and errors on the other half, and the halves exchanged:
/// the two colours of a checkerboard, (column + row) even and odd, which both span the board.
///
/// Nothing where the views that are left do not give a camera.
/// @param fit  the solution for all views, of one camera and one board; the board's shape is not estimated
///             again
[[nodiscard]] std::optional<HeldOutErrors> heldOutErrors(const Fit& fit, const CancelFlag* cancel = nullptr);

/// The fold of view v of num_views in order of name, from 0 to numFolds() - 1.
///
/// Each fold is four stretches of neighbouring views, a stretch each from every quarter of the sequence (with
/// fewer than 20 views, single views). Frames of a video are nearly the same as their neighbours: if
/// neighbours were all in different folds, a view's twin would have had its part in the camera; if a fold
/// were one stretch, no other view might have looked where it looks.
[[nodiscard]] int foldOf(std::size_t v, std::size_t num_views);
[[nodiscard]] int numFolds(std::size_t num_views);

/// What cross-validation says of a calibration.
struct HoldoutReport {
  double rms_px = std::numeric_limits<double>::quiet_NaN();  ///< sqrt(mean of dx^2 + dy^2); NaN if unknown
  int num_folds = 0;    ///< 0: the views of the other folds give no camera
  int num_corners = 0;  ///< with a held-out error
  int num_unseen = 0;   ///< further ones that the camera of the other views does not see
};

[[nodiscard]] HoldoutReport holdoutReport(const std::optional<HeldOutErrors>& errors);

}  // namespace alidade
