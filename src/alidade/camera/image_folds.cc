// SPDX-License-Identifier: MIT
#include "alidade/camera/image_folds.h"

#include <algorithm>

#include "alidade/camera/batch.h"

namespace alidade {

std::vector<Eigen::Vector2d> imageBorder(ImageSize size) {
  const double right = size.width - 0.5;
  const double bottom = size.height - 0.5;
  std::vector<Eigen::Vector2d> border;
  for (int x = 0; x <= size.width; ++x) {
    border.emplace_back(x - 0.5, -0.5);
    border.emplace_back(x - 0.5, bottom);
  }
  for (int y = 1; y < size.height; ++y) {
    border.emplace_back(-0.5, y - 0.5);
    border.emplace_back(right, y - 0.5);
  }
  return border;
}

bool foldsInsideImage(const AnyCamera& camera, ImageSize size) {
  DomainCertificate domain;  // of an image that is not seen whole
  domain.cone = camera.cone();
  if (!foldsInsideImage(domain)) return false;
  const std::vector<Eigen::Vector2d> border = imageBorder(size);
  std::vector<double> u;
  std::vector<double> v;
  for (const Eigen::Vector2d& pixel : border) {
    u.push_back(pixel.x());
    v.push_back(pixel.y());
  }
  std::vector<double> x(u.size());
  std::vector<double> y(u.size());
  std::vector<double> z(u.size());
  std::vector<ProjectStatus> status(u.size());
  unprojectBatch(camera, {.u = u, .v = v}, {.x = x, .y = y, .z = z, .status = status});
  domain.full_image =
      std::all_of(status.begin(), status.end(), [](ProjectStatus s) { return s == ProjectStatus::kOk; });
  return foldsInsideImage(domain);
}

}  // namespace alidade
