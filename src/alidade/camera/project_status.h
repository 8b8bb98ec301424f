// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <numbers>
#include <string_view>

#include <Eigen/Core>

namespace alidade {

/// Outcome of a projection: a pixel, or the reason why there is none.
enum class ProjectStatus : std::uint8_t {
  kOk,
  kBehind,         ///< not in front of a camera that sees only forward
  kOutsideDomain,  ///< beyond the first fold or the domain of the model, or not a valid point (not
                   ///< finite, or at a distance outside 1e-100 to 1e100)
};

/// "ok", "behind" or "outside". `alidade project`, which knows the image size, also prints "out_of_image".
[[nodiscard]] constexpr std::string_view statusId(ProjectStatus status) {
  if (status == ProjectStatus::kOk) return "ok";
  return status == ProjectStatus::kBehind ? "behind" : "outside";
}

/// The projection of a point in the camera frame. `pixel` is NaN unless the status is kOk.
struct Projection {
  Eigen::Vector2d pixel = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  ProjectStatus status = ProjectStatus::kOutsideDomain;

  [[nodiscard]] bool ok() const { return status == ProjectStatus::kOk; }
};

/// The cone around the optical axis in which the projection is one-to-one.
struct CertifiedCone {
  double max_angle_rad = std::numbers::pi;  ///< largest field angle that may be used
  bool is_limited_by_fold = false;          ///< limited by a fold or pole; false: by the model itself
};

}  // namespace alidade
