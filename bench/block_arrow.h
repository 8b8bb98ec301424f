// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/calibrate/bundle_adjustment.h"

namespace alidade {

/// The floor of solveBundle() for radtan: Levenberg and Marquardt's method by hand on the same sums over
/// corners and the same elimination of poses, without Ceres. Nothing else: no options, no reasons, and it
/// takes for granted that the start can be evaluated.
[[nodiscard]] BundleSummary solveBlockArrow(std::span<const std::vector<Observation>> views,
                                            BundleState& state, HuberLoss loss);

}  // namespace alidade
