// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "alidade/camera/any_camera.h"
#include "alidade/imagery/output_view.h"

// Search for the extent of views on the plane of a projection.
namespace alidade::detail {

/// True for a place within the limits of views (kMaxTangentAngleRad).
[[nodiscard]] bool isLaidOut(ViewProjection projection, const Eigen::Vector2d& plane);
/// The largest multiple of `offset` within the limits of views. A window with a corner at twice that reaches
/// beyond the limits wherever it is centred.
[[nodiscard]] double farthestMultiple(ViewProjection projection, const Eigen::Vector2d& offset);

/// Offsets of the centres of the border pixels from the centre of an image.
[[nodiscard]] std::vector<Eigen::Vector2d> borderOffsets(ImageSize size);
[[nodiscard]] Eigen::Vector2d middleOf(ImageSize size);

/// @throws Error (kUsage) for an output that remap() cannot make; Error (kInput) for a source that it cannot
/// read
void checkViewSizes(ImageSize source_size, ImageSize size);

/// The pixel of the optical axis, and the pixels per radian along u and v there.
/// @throws Error (kInput) at `where` for a camera that does not see along its axis
[[nodiscard]] std::pair<Eigen::Vector2d, Eigen::Vector2d> axisOf(const AnyCamera& camera,
                                                                 const std::string& where,
                                                                 const std::string& next_step);

/// Half the width of a field of view on the plane: a tangent if `is_flat`, otherwise an angle.
/// @param next_step  for a field that is too large for a flat view
/// @throws Error (kUsage) for fields above `largest_rad`
[[nodiscard]] double halfWidthOf(double field_rad, bool is_flat, double largest_rad,
                                 const std::string& expected, const std::string& next_step);

/// Pixels per unit of the plane at which a view of this size shows an area of this extent.
[[nodiscard]] double scaleOfAll(ImageSize size, const Eigen::Vector2d& extent);

/// The part of the plane that source pixels fill.
struct PlaneBox {
  Eigen::AlignedBox2d shown;
  int num_shown = 0;
  int num_cut = 0;
};
/// The place on the plane of a ray in the camera frame; nothing beyond the limits of views.
using PlaneOfRay = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector3d&)>;
/// Examines all border pixels, every 16th pixel inside, and all pixels in cells where that is not enough.
/// Elsewhere it is, because a place with shown pixels all around is never an extreme.
[[nodiscard]] PlaneBox boxOfAll(const AnyCamera& camera, ImageSize size, const PlaneOfRay& plane_of);

/// The largest units of the plane per pixel, up to `limit`, at which the places at these offsets (pixels),
/// and all places on the lines to them, have a source. `has_source` takes a place relative to the centre.
[[nodiscard]] double largestWindow(std::span<const Eigen::Vector2d> offsets, double limit,
                                   const std::function<bool(const Eigen::Vector2d&)>& has_source);

/// True if all four pixels around a place exist.
[[nodiscard]] bool isBetweenPixelCentres(const Eigen::Vector2d& pixel, ImageSize size);

}  // namespace alidade::detail
