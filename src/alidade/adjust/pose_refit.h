// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "alidade/adjust/corner_groups.h"
#include "alidade/adjust/observation.h"
#include "alidade/adjust/view_kernel.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// The pose with the least robust cost near a good one, the camera as it is: Gauss and Newton's steps, each
/// halved until it lowers the cost. Some microseconds a view, where a solver that is set up for one pose
/// takes a hundred. Nothing where a corner does not project from the pose to begin with.
[[nodiscard]] std::optional<SE3> refitPose(const ViewKernel& kernel, std::span<const double> params,
                                           std::span<const CornerGroup> corners, HuberLoss loss,
                                           const SE3& camera_from_board);
[[nodiscard]] std::optional<SE3> refitPose(std::string_view model_id, std::span<const double> params,
                                           std::span<const Observation> corners, HuberLoss loss,
                                           const SE3& camera_from_board);

}  // namespace alidade
