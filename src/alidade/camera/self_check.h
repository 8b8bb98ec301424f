// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// A point of the camera frame (metres) and its pixel, kept in a camera file so that whoever reads the file
/// can tell whether he understands it as its writer did.
struct SelfCheckPoint {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
};

/// Numbers in a file are exact, so recomputing self-check points may only differ by rounding.
inline constexpr double kSelfCheckPx = 1e-6;

/// How far a camera puts self-check points from their pixels.
struct SelfCheckOutcome {
  std::size_t worst = 0;                       ///< index of the point that is farthest off
  double worst_px = 0;                         ///< its distance; infinity: it does not project
  std::optional<std::size_t> outside_image{};  ///< the first point whose pixel is not of the image

  [[nodiscard]] bool isPassed() const { return worst_px <= kSelfCheckPx && !outside_image; }
};

/// Projects the points again: microseconds. Passed where there are none.
[[nodiscard]] SelfCheckOutcome runSelfCheck(const AnyCamera& camera, ImageSize size,
                                            std::span<const SelfCheckPoint> points);

/// What a camera file claims about its own domain.
struct DomainClaim {
  double max_angle_rad = 0;
  bool full_image = false;
};

/// Points that project all over the image (centre, corners, edges), at several depths. Pixels without a ray
/// are left out.
[[nodiscard]] std::vector<SelfCheckPoint> makeSelfCheck(const AnyCamera& camera, ImageSize size);

}  // namespace alidade
