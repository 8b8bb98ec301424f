// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Use of the scatter of the offsets (FitBoard::offset_precision): estimated together with them or kept.
enum class OffsetScatter { kEstimate, kKeep };

/// Gives the points of these boards offsets, initially zero, with a first guess of their scatter. Boards
/// without views stay even.
[[nodiscard]] Fit startedUneven(Fit fit, std::span<const std::size_t> boards);

/// Removes the offsets of a board, so that its bend alone places its points.
void makeEven(FitBoard& board);

/// Share of the errors' variance that would remain after estimating the offsets of the uneven boards, to
/// first order; 1 if the views contain no information on them.
/// @param fit    solved
/// @param limit  shares above it are of no interest: if the first, loose scatter leaves a share that is more
///               than three standard deviations above it, that share is returned
[[nodiscard]] double varianceLeftByOffsets(const Fit& fit,
                                           double limit = std::numeric_limits<double>::infinity());

/// withOffsets() until a step is shorter than this is enough for held-out errors.
inline constexpr double kHeldOutAtRest = 1e-4;

/// Estimates the offsets of the uneven boards together with everything else: the points of a board are
/// unknowns of the bundle adjustment, normally distributed about their nominal places in the plane and normal
/// to it. Their scatter maximises the likelihood of the corners (MacKay 1992, Bayesian interpolation, Neural
/// Computation 4(3), section 4). It also determines what no view can: position, orientation and size of the
/// board as a whole. A board becomes even again if the views cannot resolve the scatter of its points.
///
/// Gauss-Newton steps with all other unknowns eliminated alternate with solves for these (solve()).
/// @param fit      solved
/// @param at_rest  stops once the largest step of a point is shorter, as a share of the points' spacing
/// @returns nothing if the other unknowns are not determined, or the steps do not converge
/// @throws Cancelled
[[nodiscard]] std::optional<Fit> withOffsets(Fit fit, OffsetScatter scatter, const CancelFlag* cancel,
                                             double at_rest = 1e-7);

/// Contribution of the uncertainty of the offsets to the inverse information (per px^2) of all other
/// unknowns, with the rows and columns of jointColumns(); zero for even boards. Nothing if it is not
/// determined.
[[nodiscard]] std::optional<Eigen::MatrixXd> offsetShare(const Fit& fit);

}  // namespace alidade
