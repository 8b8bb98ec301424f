// SPDX-License-Identifier: MIT
#include "alidade/camera/image_domain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "alidade/camera/batch.h"
#include "alidade/camera/correction_field.h"

namespace alidade {
namespace {

// Points along the border of an image, one per pixel.
std::vector<Eigen::Vector2d> imageBorder(ImageSize size) {
  std::vector<Eigen::Vector2d> border;
  for (int x = 0; x <= size.width; ++x) {
    border.emplace_back(x - 0.5, -0.5);
    border.emplace_back(x - 0.5, size.height - 0.5);
  }
  for (int y = 1; y < size.height; ++y) {
    border.emplace_back(-0.5, y - 0.5);
    border.emplace_back(size.width - 0.5, y - 0.5);
  }
  return border;
}

}  // namespace

DomainCertificate certifyDomain(const AnyCamera& camera, ImageSize size) {
  constexpr int kGrid = 24;  // the interior matters only for the determinant
  std::vector<Eigen::Vector2d> pixels = imageBorder(size);
  for (int j = 1; j < kGrid; ++j) {
    for (int i = 1; i < kGrid; ++i)
      pixels.emplace_back(-0.5 + i * size.width / double{kGrid}, -0.5 + j * size.height / double{kGrid});
  }
  std::vector<double> before;  // the correction field
  for (const Eigen::Vector2d& pixel : pixels) {
    const std::optional<Eigen::Vector2d> at =
        camera.correction() == nullptr ? pixel : camera.correction()->undisplaced(pixel);
    before.push_back(at ? at->x() : std::numeric_limits<double>::quiet_NaN());
    before.push_back(at ? at->y() : 0.0);
  }
  const AnyCamera plain = camera.withCorrection(nullptr);
  std::vector<double> rays(3 * pixels.size());
  std::vector<double> J_ray_pixel(6 * pixels.size());
  std::vector<ProjectStatus> status(pixels.size());
  unprojectRows(plain, before, rays, status, J_ray_pixel.data());
  // Pixels per steradian on the axis.
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_axis;
  static_cast<void>(plain.project(Eigen::Vector3d::UnitZ(), J_axis.data()));
  const double axis_det = std::abs(J_axis.leftCols<2>().determinant());
  DomainCertificate result{
      .cone = camera.cone(), .full_image = true, .pixel_without_ray = {}, .min_relative_det = 1.0};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (status[i] != ProjectStatus::kOk) {
      result.full_image = false;
      result.min_relative_det = 0.0;
      if (!result.pixel_without_ray) result.pixel_without_ray = pixels[i];
      continue;
    }
    const Eigen::Map<const Eigen::Matrix<double, 3, 2, Eigen::RowMajor>> J(&J_ray_pixel[6 * i]);
    const double steradians = J.col(0).cross(J.col(1)).norm();
    result.min_relative_det = std::min(result.min_relative_det, 1.0 / (steradians * axis_det));
  }
  return result;
}

bool foldsInsideImage(const DomainCertificate& domain) {
  return !domain.full_image && domain.cone.is_limited_by_fold &&
         domain.cone.max_angle_rad < std::numbers::pi / 2;
}

bool foldsInsideImage(const AnyCamera& camera, ImageSize size) {
  DomainCertificate domain;  // assumes that part of the image has no ray
  domain.cone = camera.cone();
  if (!foldsInsideImage(domain)) return false;
  const std::vector<Eigen::Vector2d> border = imageBorder(size);
  return std::any_of(border.begin(), border.end(),
                     [&](const Eigen::Vector2d& pixel) { return !camera.unproject(pixel); });
}

}  // namespace alidade
