// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// The affine step of a camera: fx, fy, cx, cy in pixels.
struct AffineStart {
  double fx = 0, fy = 0, cx = 0, cy = 0;
};

/// Zhang's closed form without skew: fx, fy, cx, cy from three or more homographies board plane -> pixels
/// (Zhang 2000, A flexible new technique for camera calibration, eqs. 3, 4 and appendix B). Nothing where the
/// views do not determine them or the result is no camera.
[[nodiscard]] std::optional<AffineStart> zhangIntrinsics(std::span<const Eigen::Matrix3d> pixel_from_board,
                                                         ImageSize size);

/// The same constraints with the principal point held at the image's centre and square pixels: one unknown,
/// which noise and distortion move far less.
[[nodiscard]] std::optional<AffineStart> centredFocal(std::span<const Eigen::Matrix3d> pixel_from_board,
                                                      ImageSize size);

/// Starts worth trying, the closed forms first, then focal lengths for fields of view from 15 to 120 degrees
/// across the image, for sets of views where distortion or noise defeats the closed forms.
[[nodiscard]] std::vector<AffineStart> affineStarts(std::span<const Eigen::Matrix3d> pixel_from_board,
                                                    ImageSize size);

}  // namespace alidade
