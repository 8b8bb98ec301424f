// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/detect/corner/corner_task.h"

namespace alidade {

/// The corner as the saddle of the grey levels near `start`, px of the image: for squares too small, or too
/// blurred, for the edge model. Nothing if there is no saddle with the contrast of four squares.
[[nodiscard]] std::optional<CornerFit> fitSaddleCorner(const CornerTask& task, const Eigen::Vector2d& start);

}  // namespace alidade
