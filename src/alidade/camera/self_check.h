// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// A point of the camera frame (metres) and its pixel, stored in a camera file so that a reader can check
/// that it interprets the file as the writer did.
struct SelfCheckPoint {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
};

/// Numbers in a file are exact, so recomputed pixels may differ only by rounding.
inline constexpr double kSelfCheckPx = 1e-6;

/// Distances between the projections of the self-check points and their stated pixels.
struct SelfCheckOutcome {
  std::size_t worst = 0;                       ///< index of the point with the largest distance
  double worst_px = 0;                         ///< its distance; infinity if it does not project
  std::optional<std::size_t> outside_image{};  ///< the first point whose pixel is outside the image

  [[nodiscard]] bool isPassed() const { return worst_px <= kSelfCheckPx && !outside_image; }
};

/// Projects the points again, which takes microseconds. Passes if there are no points.
[[nodiscard]] SelfCheckOutcome runSelfCheck(const AnyCamera& camera, ImageSize size,
                                            std::span<const SelfCheckPoint> points);

/// The domain that a camera file states.
struct DomainClaim {
  double max_angle_rad = 0;
  bool full_image = false;
};

/// Points that project to the centre, corners and edges of the image, at several depths. Pixels without a ray
/// are skipped.
[[nodiscard]] std::vector<SelfCheckPoint> makeSelfCheck(const AnyCamera& camera, ImageSize size);

}  // namespace alidade
