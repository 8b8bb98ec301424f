// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A camera and the poses of the views.
struct PosedCamera {
  std::vector<double> params;
  std::vector<std::optional<SE3>> poses;  ///< camera_from_board, one per view
};

/// The loss for an initial guess: errors beyond half a percent of the image diagonal get less
/// weight.
[[nodiscard]] HuberLoss startLoss(ImageSize size);

/// Replaces each pose that is missing, or has a higher cost, by the pose estimated from the rays of the
/// corners. With a poor camera, a view may converge to the wrong one of two similar tilts, which small steps
/// cannot correct. Returns false if nothing changed.
/// @param views  the corners of each view
bool improvePoses(std::string_view model_id, std::span<const std::vector<Observation>> views, HuberLoss loss,
                  PosedCamera& camera);

/// The same for a fit of one camera.
bool improvePoses(Fit& fit);

/// The fit with all poses estimated from rays; std::nullopt if that fails for a view.
[[nodiscard]] std::optional<Fit> posedAnew(Fit fit);

}  // namespace alidade
