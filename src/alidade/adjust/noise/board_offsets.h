// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Whether the scatter of the offsets (FitBoard::offset_precision) is estimated with them.
enum class OffsetScatter { kEstimate, kKeep };

/// Lets the points of these boards have offsets, of zero so far, with a first guess of their scatter. Boards
/// that no view shows stay even.
[[nodiscard]] Fit startedUneven(Fit fit, std::span<const std::size_t> boards);

/// Takes the points of a board for where its bend puts them.
void makeEven(FitBoard& board);

/// The share of the errors' variance that would be left with the offsets of the boards that are uneven, to
/// first order; 1 where the views say nothing of them.
/// @param fit  solved
[[nodiscard]] double varianceLeftByOffsets(const Fit& fit);

/// Estimates the offsets of the boards that are uneven with everything else: the points of a board as
/// unknowns of the bundle adjustment, in the plane and across it normally distributed about their places.
/// How far they scatter is what makes the corners likeliest (MacKay 1992, Bayesian interpolation, Neural
/// Computation 4(3), section 4). It also decides what no view can tell: position, orientation and size of
/// the board as a whole. A board whose points scatter by less than the views can tell is even again.
///
/// Steps of Gauss and Newton with all other unknowns eliminated, between solves of these (solve()).
/// @param fit  solved
/// @returns nothing where the other unknowns are not determined, or the steps do not come to rest
/// @throws Cancelled
[[nodiscard]] std::optional<Fit> withOffsets(Fit fit, OffsetScatter scatter, const CancelFlag* cancel);

/// What the uncertainty of the offsets adds to the inverse information (per px^2) of all other unknowns, with
/// the rows and columns of jointColumns(); zero for even boards. Nothing where it is not determined.
[[nodiscard]] std::optional<Eigen::MatrixXd> offsetShare(const Fit& fit);

}  // namespace alidade
