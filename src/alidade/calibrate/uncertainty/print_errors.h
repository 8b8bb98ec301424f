// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/core/diagnosis.h"

namespace alidade {

/// The displacement of each point of a board of tags per unit of the gap between tags, metres. Empty for
/// boards of other kinds.
[[nodiscard]] std::vector<Eigen::Vector3d> gapOffsets(const Board& board);

/// Adds to the stretch and gap of uneven boards what their estimated offsets contain of these.
/// @param errors  of `fit`; the result
void includeOffsets(const Fit& fit, std::vector<CommonError>& errors);

/// Null if the views do not determine it.
[[nodiscard]] const CommonError* findError(std::span<const CommonError> errors, CommonCause cause,
                                           std::size_t board);

/// The changes of the parameters by stretches that the views show and the fit ignores, one standard deviation
/// each: N x boards. Below two standard deviations a board is taken as square.
/// @param boards  those of the fit
[[nodiscard]] DenseMatrix ignoredStretches(const std::vector<FitBoard>& boards,
                                           std::span<const CommonError> errors);

/// Standard deviation of the size of a board, as a share of it. Its width and height are off independently of
/// each other, and images show only their ratio; and a gap that is not used may be wrong or only look so.
/// Lengths measured with the board are as uncertain.
/// @param board  the index of `of`
[[nodiscard]] double sizeStd(const FitBoard& of, std::span<const CommonError> errors, std::size_t board);

/// True if images show another gap than the board has, certainly and by more than print changes it.
[[nodiscard]] bool isGapContradicted(const Board& board, const CommonError& gap);

/// True for a diagnosis of the SPEC, which no image and no lens can mend; the result is that of the gap seen.
[[nodiscard]] bool isOfSpec(const Diagnosis& diagnosis);

/// The board with a seen gap, to four digits and within what a SPEC may say.
[[nodiscard]] Board withSeenGap(const Board& board, double gap);

/// Gives boards the gap that images show where they contradict that of the SPEC by more than blooming could.
/// A board whose SPEC was refuted before keeps its gap.
/// @param boards  those of the fit; the result
/// @param stated  the boards as given
/// @returns false if no board changes
[[nodiscard]] bool reviseGaps(const Fit& fit, std::span<const CommonError> errors,
                              std::span<const Board> stated, std::vector<Board>& boards);

}  // namespace alidade
