// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/calibrate/calibration.h"
#include "alidade/compare/projection_difference.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"
#include "alidade/validate/held_out/held_scores.h"

namespace alidade {

/// Whether either colour of the board's corners in this view tells a pose, from which the other colour can be
/// predicted: four corners or more, not all in one row or column.
[[nodiscard]] bool isTestable(const Checkerboard& board, const View& view);

/// The best pose of a view for the camera as it is; nothing where it does not see the corners from any.
/// @param corners  the view's, on the board as it is bent
[[nodiscard]] std::optional<SE3> poseOf(const ComparedCamera& camera, const Checkerboard& board,
                                        std::span<const Observation> corners, HuberLoss loss);

/// How much a view counts: views that are blurred or moved tell less. The inverse of the variance of its
/// corners, as the freed calibration has them, taken together with some of the mean of all.
[[nodiscard]] double weightOf(const Fit& freed, std::size_t view);

/// The same views, posed for the freed camera.
/// @param held  its views' sources are indices into those of `freed`
[[nodiscard]] PosedViews posedByFreed(const PosedViews& held, const Fit& freed);

/// The views posed for another camera of the model: refitted from where they are and, where they are given,
/// from the freed camera's poses, of which the better counts, for far from the truth a pose may rest in a
/// tilt that is not the board's. Nothing where a view is not seen from either.
[[nodiscard]] std::optional<PosedViews> reposed(const AnyCamera& camera, const PosedViews& near,
                                                const PosedViews* freed);

}  // namespace alidade
