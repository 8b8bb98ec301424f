// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// The displacement of each point of a board of tags per unit of the gap between tags, metres. Empty for
/// boards of other kinds.
[[nodiscard]] std::vector<Eigen::Vector3d> gapOffsets(const Board& board);

/// A stretch or a gap in the print of a board: the common error, and what the offsets of an uneven board
/// contain of it. Nothing if the views do not determine it.
/// @param errors  of the calibration with this fit
[[nodiscard]] std::optional<CommonError> printError(const Fit& fit, std::span<const CommonError> errors,
                                                    CommonCause cause, std::size_t board);

/// Root of the variance of a board's stretch beyond that of its estimate; 0 below two standard deviations,
/// where most boards are square.
[[nodiscard]] double sureStretch(const CommonError& stretch);

/// Standard deviation of the size of a board with this stretch, as a share of it: width and height are off
/// independently of each other, and images show only their ratio. Lengths measured with it are as uncertain.
[[nodiscard]] double sizeStd(const FitBoard& board, const CommonError& stretch);

/// Gives boards the gap that images show where it certainly differs from that of the SPEC, by more than print
/// and blur change it. A board whose SPEC was refuted before keeps its gap.
/// @param boards  those of the fit; the result
/// @param stated  the boards as given
/// @returns false if no board changes
[[nodiscard]] bool reviseGaps(const Fit& fit, std::span<const CommonError> errors,
                              std::span<const Board> stated, std::vector<Board>& boards);

}  // namespace alidade
