// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "alidade/camera/any_camera.h"
#include "alidade/imagery/output_view.h"

// How views are laid out on the plane of a projection.
namespace alidade::detail {

/// True for a place that is not farther from the axis than views are laid out (kMaxTangentAngleRad).
[[nodiscard]] bool isLaidOut(ViewProjection projection, const Eigen::Vector2d& plane);
/// The largest multiple of `offset` that is laid out.
[[nodiscard]] double farthestMultiple(ViewProjection projection, const Eigen::Vector2d& offset);

/// Offsets of the border pixels' centres from the middle of an image.
[[nodiscard]] std::vector<Eigen::Vector2d> borderOffsets(ImageSize size);
[[nodiscard]] Eigen::Vector2d middleOf(ImageSize size);

/// @throws Error (kUsage) for an output that remap() cannot make, Error (kInput) for such a source
void checkViewSizes(ImageSize source_size, ImageSize size);

/// The pixel of the optical axis and, there, the pixels per radian along u and v.
/// @throws Error (kInput) at `where` for a camera that does not see along its axis
[[nodiscard]] std::pair<Eigen::Vector2d, Eigen::Vector2d> axisOf(const AnyCamera& camera,
                                                                 const std::string& where,
                                                                 const std::string& next_step);

/// Half of a field of view on the plane: `is_flat`, a tangent, or else an angle.
/// @param next_step  for a field that is too large for a flat view
/// @throws Error (kUsage) for fields above `largest_rad`
[[nodiscard]] double halfWidthOf(double field_rad, bool is_flat, double largest_rad,
                                 const std::string& expected, const std::string& next_step);

/// Pixels per unit of the plane at which views of this size show all of a part of the plane.
[[nodiscard]] double scaleOfAll(ImageSize size, const Eigen::Vector2d& extent);

/// The part of the plane that source pixels fill.
struct PlaneBox {
  Eigen::AlignedBox2d shown;
  int num_shown = 0;
  int num_cut = 0;
};
/// The place on the plane of a ray in the camera frame; nothing if it is not laid out.
using PlaneOfRay = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector3d&)>;
/// Looks at all border pixels, at every 16th pixel inside, and at all pixels where that is not enough.
/// Elsewhere it is: a place with shown pixels all around is not an extreme one.
[[nodiscard]] PlaneBox boxOfAll(const AnyCamera& camera, ImageSize size, const PlaneOfRay& plane_of);

/// The largest units of the plane per pixel, up to `limit`, at which all border pixels of a window have a
/// source, and so have all places on the lines to them. `has_source` gets the place relative to the middle.
[[nodiscard]] double largestWindow(ImageSize size, double limit,
                                   const std::function<bool(const Eigen::Vector2d&)>& has_source);

/// True where all four pixels around a place exist.
[[nodiscard]] bool isBetweenPixelCentres(const Eigen::Vector2d& pixel, ImageSize size);

}  // namespace alidade::detail
