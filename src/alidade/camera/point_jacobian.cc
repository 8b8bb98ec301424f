// SPDX-License-Identifier: MIT
#include "alidade/camera/point_jacobian.h"

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>

#include "alidade/core/error.h"

namespace alidade {
namespace {

using Matrix23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;

}  // namespace

bool pixelJacobian(const AnyCamera& camera, const SE3& camera_from_points, const Eigen::Vector3d& point,
                   std::span<double> J_px_inputs) {
  const std::size_t num_inputs = numPixelInputs(camera);
  expect(J_px_inputs.size() == 2 * num_inputs, "two rows of a Jacobian");
  return camera.visit([&](const auto& c) {
    constexpr auto kNumParams = static_cast<std::size_t>(std::decay_t<decltype(c)>::kNumParams);
    Matrix23 J_px_cam;
    double J_px_params[2 * kNumParams];
    if (!c.project(camera_from_points * point, J_px_cam.data(), J_px_params).ok()) {
      std::fill(J_px_inputs.begin(), J_px_inputs.end(), std::numeric_limits<double>::quiet_NaN());
      return false;
    }
    // T exp(xi) p = T p + R (xi_translation + xi_rotation x p) to first order in xi.
    const Matrix23 J_px_point = J_px_cam * camera_from_points.rotation.matrix();
    const Matrix23 J_px_rotation = -J_px_point * hat(point);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto row = J_px_inputs.subspan(i * num_inputs, num_inputs);
      const auto r = static_cast<Eigen::Index>(i);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto column = static_cast<Eigen::Index>(k);
        row[k] = row[3 + k] = J_px_point(r, column);
        row[6 + k] = J_px_rotation(r, column);
      }
      std::copy_n(J_px_params + i * kNumParams, kNumParams, row.begin() + 9);
    }
    return true;
  });
}

std::optional<RayJacobian> rayJacobian(const AnyCamera& camera, const Eigen::Vector3d& ray) {
  Matrix23 J_px_ray;
  const bool has_pixel =
      camera.visit([&](const auto& c) { return c.project(ray, J_px_ray.data(), nullptr).ok(); });
  if (!has_pixel) return std::nullopt;
  // A change of a unit ray is perpendicular to it, as both rows are: a pixel does not depend on the length.
  // So it is the combination of the vectors below whose products with the rows are 1 and 0.
  const Eigen::Vector3d a = J_px_ray.row(0);
  const Eigen::Vector3d b = J_px_ray.row(1);
  const double det = a.cross(b).dot(ray);
  if (det == 0.0) return std::nullopt;
  RayJacobian J_ray_px;
  J_ray_px << b.cross(ray) / det, ray.cross(a) / det;
  return J_ray_px;
}

}  // namespace alidade
