// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/validate/held_out/held_scores.h"

namespace alidade {

/// Errors of this size an axis, px, count as chance even where corners are without noise: what is left of
/// those is rounding, and how a change compares with it says nothing.
inline constexpr double kFinestPx = 1e-3;

/// How far views are from what a camera predicts at their poses.
struct Misfit {
  double rms_px = 0;            ///< sqrt(mean of dx^2 + dy^2) over all corners
  double squares = 0;           ///< sum over the corners, px^2
  double weighted_squares = 0;  ///< sum over the corners, each by its view's weight, px^2
};
[[nodiscard]] Misfit misfitOf(const PosedViews& posed);

/// Whether a camera is off by so much that the refitted poses cannot hide it: how improbable the ratio of its
/// squared errors to those of the freed camera would be if it were right, as a normal variable.
///
/// An F test in which corners do not count, only views: what the corners of a view have in common (blur,
/// motion, a rolling shutter) shears and stretches it as a whole, which is four numbers, of which its pose
/// takes most. Two each view brings, however many corners it has; the freed parameters take theirs away from
/// them. Of few views nothing is left: 0 then. With noise alone, which is far more numbers a view, the
/// test is far on the safe side.
/// @param held   posed for the camera as it is
/// @param freed  the same views, posed for the camera that they give
[[nodiscard]] double misfitSigmas(const PosedViews& held, const PosedViews& freed);

}  // namespace alidade
