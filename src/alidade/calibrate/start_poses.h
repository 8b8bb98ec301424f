// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "alidade/calibrate/bundle_adjustment.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// A camera with the poses of the views that it explains.
struct PosedCamera {
  std::vector<double> params;
  std::vector<std::optional<SE3>> poses;  ///< camera_from_board, one a view
};

/// The views as the solver takes them, all corners with weight 1.
[[nodiscard]] std::vector<std::vector<Observation>> observationsOf(const Checkerboard& board,
                                                                   std::span<const View> views);

/// The loss for views that are far from explained: beyond half a percent of the image's diagonal an error
/// counts less.
[[nodiscard]] HuberLoss startLoss(ImageSize size);

/// Half the sum of rho, as the solver counts it; NaN if a corner does not project.
[[nodiscard]] double viewCost(std::string_view model_id, std::span<const double> params, const SE3& pose,
                              std::span<const Observation> view, HuberLoss loss);

/// The pose nearby with the least cost, the camera as it is. Nothing where a corner does not project.
[[nodiscard]] std::optional<SE3> refinedPose(std::string_view model_id, const std::vector<double>& params,
                                             const SE3& pose, const std::vector<Observation>& view,
                                             HuberLoss loss);

/// Puts the pose by the corners' rays through the camera in place of each pose that costs more or is missing.
/// From a poor camera, a view may have come to the wrong one of the two tilts that look alike from afar; from
/// there no small step leads back. False if all was well.
bool improvePoses(std::string_view model_id, const Checkerboard& board, std::span<const View> views,
                  HuberLoss loss, PosedCamera& camera);

}  // namespace alidade
