// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// Each view votes for a displacement field over the image, bilinear between the nodes of a coarse grid, by
/// the score of the field at zero with pose and intrinsics eliminated (Rao 1948, Large sample tests of
/// statistical hypotheses concerning several parameters). Otherwise, poses that adapt to the lens would hide
/// the common errors of the views.
/// @param fit  of one camera, solved
[[nodiscard]] ImageBias imageBias(const Fit& fit);

}  // namespace alidade
