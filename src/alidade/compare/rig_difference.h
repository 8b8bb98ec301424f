// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/compare/projection_difference.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A camera of a rig to compare.
struct PlacedCamera {
  const AnyCamera* camera = nullptr;
  ImageSize size;
  SE3 camera_from_rig;
};

/// Disagreement of two rigs on the pixel in one camera that corresponds to a pixel of another.
struct TransferDifference {
  std::size_t from = 0;  ///< index of the camera with the grid of pixels
  std::size_t to = 0;    ///< index of the camera in whose pixels the values below are given
  int num_compared = 0;  ///< pixels of the grid that both rigs see in the image of `to`
  double rms_px = 0;
  double p95_px = 0;  ///< 95th percentile of the lengths
  double max_px = 0;
  Eigen::Vector2d worst_pixel{0, 0};  ///< of `from`
};

/// Difference between two poses of a camera relative to the first camera.
struct PlaceDifference {
  double distance_m = 0;  ///< between the camera's positions, in the frame of the first camera
  double angle_rad = 0;
};

struct RigDifference {
  double distance_m = 0;                ///< of the points
  std::vector<PlaceDifference> places;  ///< one per camera; the first is zero
  /// For each camera, the transfer from the camera with the largest p95_px; none for a camera that sees too
  /// little of what others see (less than a tenth of their grid).
  std::vector<std::optional<TransferDifference>> transfers;
};

/// 10 times the largest distance between two cameras, or 1 m if all are at one place.
[[nodiscard]] double usualDistance(std::span<const PlacedCamera> rig);

/// Compares two rigs of the same cameras, in the same order, with images of equal sizes. The frames of the
/// rigs do not matter. A pixel of one camera is taken as the image of a point at `distance_m` from it, and
/// projected by another camera, with each of the rigs, so the result includes differences of both lenses and
/// of the pose between them. The pixels are a grid of 40 along the longer side.
/// @pre equally many cameras, two or more; distance_m positive and finite
[[nodiscard]] RigDifference rigDifference(std::span<const PlacedCamera> a, std::span<const PlacedCamera> b,
                                          double distance_m);

}  // namespace alidade
