// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/imagery/output_view.h"

namespace alidade {

/// Where a view shows a ray (any length); nothing where it has no place.
inline std::optional<Eigen::Vector2d> pixelFromRay(const OutputView& view, const Eigen::Vector3d& ray) {
  const auto plane = planeFromRay(view.projection, ray);
  if (!plane) return std::nullopt;
  return Eigen::Vector2d(view.scale_px.cwiseProduct(*plane) + view.axis_px);
}

}  // namespace alidade
