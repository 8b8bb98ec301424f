// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// Each view votes for a displacement field over the image, bilinear between the nodes of a coarse grid, by
/// the score of the field at zero with the pose and the intrinsics following (Rao 1948, Large sample tests of
/// statistical hypotheses concerning several parameters). Without that, poses that give way to the lens
/// would hide what the views have in common.
/// @param fit  of one camera, solved
[[nodiscard]] ImageBias imageBias(const Fit& fit);

}  // namespace alidade
