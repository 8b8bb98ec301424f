// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// A part of an image: its top-left pixel and its size in pixels.
struct PixelRect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// The camera of an image that was cropped, resized, binned or rotated. It projects every scene point to the
/// edited position of its pixel; the lens is unchanged.
struct EditedCamera {
  AnyCamera camera;
  ImageSize size;
  /// The old camera frame in the new one: p_new = new_from_old * p_old. The identity unless the image was
  /// rotated. Poses change accordingly: new_camera_from_board = new_from_old * camera_from_board.
  Eigen::Matrix3d new_from_old = Eigen::Matrix3d::Identity();
  /// Derivatives of the new parameters with respect to the old ones, in storage order; the edits are affine
  /// in the parameters.
  DenseMatrix J_new_old;
};

/// Crops the image: subtracts the origin of the part from cx, cy.
/// @throws Error (kUsage) if the part is empty or extends beyond the image
[[nodiscard]] EditedCamera cropCamera(const AnyCamera& camera, ImageSize size, const PixelRect& part);

/// Resizes the image: on each axis, with s = new size / old size, a coordinate c becomes s (c + 0.5) - 0.5.
/// @throws Error (kUsage) if a camera file cannot state the new size: a side outside 1 to kMaxImageSide
/// pixels, or more than 2^30 pixels in total
[[nodiscard]] EditedCamera resizeCamera(const AnyCamera& camera, ImageSize size, ImageSize new_size);

/// Combines `factor` x `factor` pixels into one. Incomplete blocks on the right and at the bottom are cropped
/// first.
/// @throws Error (kUsage) unless 1 <= factor and at least one pixel remains
[[nodiscard]] EditedCamera binCamera(const AnyCamera& camera, ImageSize size, int factor);

/// Rotates the image clockwise by quarter turns (any integer; negative: counterclockwise). After one quarter
/// turn, old pixel (x, y) is at (height - 1 - y, x).
///
/// The axes of the camera frame rotate with the image, so that x points right and y down in the new image:
/// after one quarter turn x_new = -y_old, y_new = x_old, z_new = z_old. Directional lens terms rotate too.
/// @throws Error (kInput) for an odd number of turns if the model has no such lens; see CameraModel::canTurn
[[nodiscard]] EditedCamera rotateCamera(const AnyCamera& camera, ImageSize size, int quarter_turns);

/// The longest side of an image that a camera file can state.
inline constexpr int kMaxImageSide = 1'000'000;

}  // namespace alidade
