// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// Largest angle from the optical axis to which views extend if the plane grows without bound: from the axis
/// itself for a rectilinear view, from the horizon for a cylindrical one. At 75 degrees, a pixel covers 15
/// times the length that it covers on the axis.
inline constexpr double kMaxTangentAngleRad = 75 * std::numbers::pi / 180;

/// Layout of rays on the plane of an image without distortion. Rays are those of the camera frame: x right, y
/// down, z forward.
enum class ViewProjection {
  kRectilinear,      ///< (x / z, y / z): straight lines stay straight; less than 180 degrees
  kCylindrical,      ///< (atan2(x, z), y / hypot(x, z)): vertical lines stay straight; all around
  kEquirectangular,  ///< (atan2(x, z), atan2(y, hypot(x, z))): longitude and latitude; all directions
};

/// "rectilinear", "cylindrical", "equirectangular"
[[nodiscard]] std::string_view projectionName(ViewProjection projection);
[[nodiscard]] const std::vector<std::string>& projectionNames();  ///< in the order of ViewProjection
/// @throws Error (kUsage) for an unknown name
[[nodiscard]] ViewProjection projectionOf(std::string_view name);

/// Place of a ray (any length) on the plane of a projection, dimensionless or in radians; nothing for rays
/// that do not point forward (rectilinear), vertical rays (cylindrical) and invalid rays.
[[nodiscard]] std::optional<Eigen::Vector2d> planeFromRay(ViewProjection projection,
                                                          const Eigen::Vector3d& ray);

/// Ray (not of unit length) of a place on the plane; nothing beyond half a turn in either direction and
/// beyond the poles, so that nothing appears twice.
[[nodiscard]] std::optional<Eigen::Vector3d> rayFromPlane(ViewProjection projection,
                                                          const Eigen::Vector2d& plane);

/// Rays of a row of pixels, one element for each; NaN where there is none.
struct RayColumns {
  std::span<double> x, y, z;

  void set(std::size_t column, const std::optional<Eigen::Vector3d>& ray) const;
};

/// An image without distortion, with the ray of each pixel. A pixel is scale_px * plane + axis_px, by
/// coordinates; pixel (0, 0) is the centre of the top left pixel.
struct OutputView {
  ViewProjection projection = ViewProjection::kRectilinear;
  ImageSize size;
  /// Pixels per unit of the plane: the focal lengths (rectilinear), or pixels per radian, equal on both axes.
  Eigen::Vector2d scale_px = Eigen::Vector2d::Ones();
  Eigen::Vector2d axis_px = Eigen::Vector2d::Zero();  ///< where the optical axis (0, 0, 1) appears

  [[nodiscard]] Eigen::Vector2d planeFromPixel(const Eigen::Vector2d& pixel) const {
    return (pixel - axis_px).cwiseQuotient(scale_px);
  }
  [[nodiscard]] std::optional<Eigen::Vector3d> rayFromPixel(const Eigen::Vector2d& pixel) const {
    return rayFromPlane(projection, planeFromPixel(pixel));
  }
  /// The rays of all pixels of a row; they differ from rayFromPixel() by rounding.
  void raysOfRow(std::size_t row, const RayColumns& rays) const;

  /// Angle between the leftmost and the rightmost edge of the pixels in the row of the axis, radians; at most
  /// a full turn.
  [[nodiscard]] double horizontalFieldRad() const;
};

}  // namespace alidade
