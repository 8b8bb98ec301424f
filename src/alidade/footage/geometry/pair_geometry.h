// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/footage/geometry/two_view.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// Two cameras and the pose of the second one. The translation has length 1.
struct PosedPair {
  AnyCamera first;
  AnyCamera second;
  SE3 second_from_first;
};

/// A match of two cameras at one of several instants.
struct TimedMatch {
  PixelMatch pixels;
  std::size_t instant = 0;
};

/// A match as unit rays, and their derivatives by the pixels.
struct PairRays {
  Eigen::Vector3d first;
  Eigen::Vector3d second;
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_first;
  Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_second;
};
/// @returns nothing if a pixel has no ray
[[nodiscard]] std::optional<PairRays> raysOf(const PosedPair& pair, const PixelMatch& match);

/// Signed Sampson error of each match, px; NaN if a pixel has no ray.
[[nodiscard]] std::vector<double> sampsonErrors(const PosedPair& pair, std::span<const TimedMatch> matches);

}  // namespace alidade
