// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// A part of an image: its top-left pixel and its size, pixels.
struct PixelRect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// The camera of an image that was cropped, resized, binned or rotated. It shows every point of the scene at
/// the pixel to which the edit took it; the lens is the same one.
struct EditedCamera {
  AnyCamera camera;
  ImageSize size;
  /// Axes of the new camera frame from those of the old: p_new = new_from_old * p_old. The identity unless
  /// the image was rotated. A pose follows: new_camera_from_board = new_from_old * camera_from_board.
  Eigen::Matrix3d new_from_old = Eigen::Matrix3d::Identity();
  /// Derivative of the new parameters by the old, in storage order; the edits are affine in the parameters.
  DenseMatrix J_new_old;
};

/// Cuts a part out of the image: cx, cy less its origin.
/// @throws Error (kUsage) if the part is empty or leaves the image
[[nodiscard]] EditedCamera cropCamera(const AnyCamera& camera, ImageSize size, const PixelRect& part);

/// Resizes the image: on each axis, with s = new size / old size, a coordinate c becomes s (c + 0.5) - 0.5.
/// @throws Error (kUsage) if a camera file could not state the new size: a side that is not 1 to
/// kMaxImageSide pixels, or more than 2^30 pixels in all
[[nodiscard]] EditedCamera resizeCamera(const AnyCamera& camera, ImageSize size, ImageSize new_size);

/// Takes `factor` x `factor` pixels together. Columns on the right and rows at the bottom that do not fill
/// one are cropped first.
/// @throws Error (kUsage) unless 1 <= factor and a pixel is left
[[nodiscard]] EditedCamera binCamera(const AnyCamera& camera, ImageSize size, int factor);

/// Rotates the image clockwise, as seen, by quarter turns (any integer; negative is counterclockwise). After
/// one, old pixel (x, y) is at (height - 1 - y, x).
///
/// The axes of the camera frame turn with the image, so that x points right and y down in the new one: after
/// one quarter turn x_new = -y_old and y_new = x_old, and z stays. Lens terms that point somewhere turn too.
[[nodiscard]] EditedCamera rotateCamera(const AnyCamera& camera, ImageSize size, int quarter_turns);

/// The longest side of an image that a camera file can state.
inline constexpr int kMaxImageSide = 1'000'000;

}  // namespace alidade
