// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "alidade/calibrate/bundle_adjustment.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// The views as the solver takes them, all corners with weight 1.
[[nodiscard]] std::vector<std::vector<Observation>> observationsOf(const Checkerboard& board,
                                                                   std::span<const View> views);

/// Intrinsics to start from, without any guess: closed forms and a few fields of view are each tried on a
/// spread of the views, the best three are solved there, and the one with the lowest robust cost wins.
/// Corners count alike, whatever their sigma: a start need not be precise. Nothing if no start can explain
/// the views at all.
[[nodiscard]] std::optional<std::vector<double>> findStart(std::string_view model_id,
                                                           const Checkerboard& board,
                                                           std::span<const View> views,
                                                           const CancelFlag* cancel);

}  // namespace alidade
