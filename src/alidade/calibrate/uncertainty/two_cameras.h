// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// Tests whether the views fall into two groups, each with its own intrinsics. To first order each place of
/// the board (placesOf()) has an information and a gradient of the intrinsics. Two groups suggested by the
/// names are compared by an F test. Otherwise k-means in this metric finds two offsets and the places of
/// each. Along the line between the offsets, a mixture of two normal distributions is compared with a single
/// one of free width, because a lens that does not follow the model, a breathing focus or a moving board
/// causes continuous variation.
/// @param fit       of one camera, solved
/// @param variance  of the coordinate of a corner of weight 1, px^2
/// @returns std::nullopt without evidence for two groups of at least three places each
[[nodiscard]] std::optional<TwoCameras> twoCameras(const Fit& fit, double variance);

}  // namespace alidade
