// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/compare/image_match.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A point that two cameras see at different pixels, with the rays of these pixels.
struct PixelPair {
  Eigen::Vector2d pixel_a;
  Eigen::Vector2d pixel_b;
  Eigen::Vector3d ray_a;  ///< unit length, frame a
  Eigen::Vector3d ray_b;  ///< unit length, frame b
  double weight = 1;      ///< of its squares, positive
  std::size_t index = 0;  ///< of pixel_a among the pixels to compare
};

/// Two cameras, and the conversion of their pixels to a common unit.
struct CameraPair {
  const AnyCamera* a = nullptr;
  const AnyCamera* b = nullptr;
  ImageMatch match;
};

/// The projection by b of the ray of pixel_a minus pixel_b, and the projection by a of the ray of pixel_b
/// minus pixel_a; both along a's axes in pixels of the finer image. Nothing if one of them does not exist.
/// Points are on a sphere of radius 1 about either camera.
struct TwoDifferences {
  Eigen::Vector2d a_to_b;
  Eigen::Vector2d b_to_a;
};
[[nodiscard]] std::optional<TwoDifferences> differencesAt(const CameraPair& cameras, const PixelPair& pair,
                                                          const SE3& b_from_a);

/// The rotation that aligns the rays of a with those of b with the smallest weighted sum of squared
/// distances; the frames may be arbitrary. Kabsch 1976, A solution for the best rotation to relate two sets
/// of vectors, Acta Crystallographica A32.
[[nodiscard]] SE3 kabschRotation(std::span<const PixelPair> pairs);

/// Fewest pairs that alignRays() accepts. A pair gives two numbers; with fewer than twice as many numbers as
/// unknowns, almost any two cameras could be aligned.
[[nodiscard]] constexpr int fewestPairs(Freed freed) {
  return freed == Freed::kRotation ? 3 : 6;
}

struct RayAlignment {
  SE3 b_from_a;               ///< the translation in units of the points' distance
  std::vector<bool> is_used;  ///< one per pair: both cameras see it
  bool is_converged = false;
};

/// The rotation or pose that minimises the weighted sum of squares of both differences over all pairs that
/// both cameras see. Swapping the cameras gives the inverse.
///
/// Gauss-Newton steps from kabschRotation(), each halved until it reduces the sum, until
/// convergence.
///
/// @param freed  nothing: the frames are the same, apart from the rotation of the image
[[nodiscard]] RayAlignment alignRays(const CameraPair& cameras, std::span<const PixelPair> pairs,
                                     std::optional<Freed> freed);

}  // namespace alidade
