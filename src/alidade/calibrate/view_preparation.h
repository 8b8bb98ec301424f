// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/estimation.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// Fewest corners from which a view is used.
inline constexpr std::size_t kMinCornersPerView = 6;

/// Checks what was given and puts views in order of their names, corners in order of their ids.
/// @throws Error (kInput), see calibrate()
void prepareViews(const Checkerboard& board, std::vector<View>& views);

/// Takes views with too few corners and copies of other views out of use.
/// @throws Error (kInput) if too few are left
void excludeUnusable(Estimation& estimation);

}  // namespace alidade
