// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// Fit of one view to a camera, which need not be that of its fit.
struct ViewFit {
  std::size_t board = 0;  ///< see View
  SE3 camera_from_board;
  std::vector<Observation> corners;     ///< all corners of the view, weighted, on the flat board
  std::vector<Eigen::Vector2d> errors;  ///< one per corner; NaN if it does not project
  double sigma_px = 0;                  ///< of the noise of its fit, see noiseSigma()

  /// True if a corner is farther off than noise can explain.
  [[nodiscard]] bool isOutlier(std::size_t corner) const;
  [[nodiscard]] std::size_t countOutliers() const;
  /// RMS of the weighted errors over that of noise, each error capped at kOutlierSigmas: about 1 for a view
  /// like the others, regardless of a few outliers.
  [[nodiscard]] double misfitRatio() const;
  /// True if noise and an inexact camera explain the errors.
  [[nodiscard]] bool isExplained() const;
};

/// Corners beyond this many standard deviations (chance 1e-14) are not noise and are left out by name.
inline constexpr double kOutlierSigmas = 8.0;

/// View `v` of the fit with all corners of `view`, which is its source.
[[nodiscard]] ViewFit fitInUse(const Fit& fit, std::size_t v, const View& view);

/// Any view, posed and refined with the fit's camera. Nothing if no pose explains it.
[[nodiscard]] std::optional<ViewFit> fitAlone(const Fit& fit, const View& view);

/// The same for many views, for which the camera is made only once.
/// @pre camera is that of `fit`
[[nodiscard]] std::optional<ViewFit> fitAlone(const Fit& fit, const AnyCamera& camera, const View& view);

/// True if the errors vary smoothly over the board, unlike noise.
/// @param board  of the view
[[nodiscard]] bool isSmooth(const Board& board, const ViewFit& view);

/// Misfit ratio above which a view stands out among these views. If no lens of the model matches the real
/// one, ratios vary between views although no single view is at fault.
[[nodiscard]] double standOutRatio(std::vector<double> ratios);

/// True if the view does not fit although others do: its misfit stands out and is more than noise.
[[nodiscard]] bool isForeign(const Fit& fit, const ViewFit& view, double stand_out_ratio);

/// Mistakes in numbering a board that no pose compensates for, each with its description ("column by column
/// instead of row by row") and the view renumbered. Numbering from a different end, turned or mirrored, is
/// not included because a pose compensates for it.
[[nodiscard]] std::vector<std::pair<std::string, View>> renumberings(const Board& board, const View& view);

/// The numbering with which all corners of a view fit the camera; nothing if none helps.
[[nodiscard]] std::optional<std::string> fittingOrder(const Fit& fit, const View& view);

}  // namespace alidade
