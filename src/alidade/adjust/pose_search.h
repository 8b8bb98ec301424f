// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "alidade/adjust/fit.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A camera with the poses of the views that it explains.
struct PosedCamera {
  std::vector<double> params;
  std::vector<std::optional<SE3>> poses;  ///< camera_from_board, one a view
};

/// The loss for views that are far from explained: beyond half a percent of the image's diagonal an error
/// counts less.
[[nodiscard]] HuberLoss startLoss(ImageSize size);

/// Puts the pose by the corners' rays through the camera in place of each pose that costs more or is missing.
/// From a poor camera, a view may have come to the wrong one of the two tilts that look alike from afar; from
/// there no small step leads back. False if all was well.
/// @param views  the corners of each view
bool improvePoses(std::string_view model_id, std::span<const std::vector<Observation>> views, HuberLoss loss,
                  PosedCamera& camera);

/// The same for a fit of one camera.
bool improvePoses(Fit& fit);

/// Poses for the camera by rays alone; nothing where a view has none.
[[nodiscard]] std::optional<Fit> posedAnew(Fit fit);

}  // namespace alidade
