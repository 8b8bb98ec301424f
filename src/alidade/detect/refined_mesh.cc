// SPDX-License-Identifier: MIT
#include "alidade/detect/refined_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include <Eigen/SVD>

namespace alidade {
namespace {

using Eigen::Vector2d;

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double turn(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

RefinedMesh refineMesh(const GrayImage& image, const CornerMesh& mesh) {
  RefinedMesh refined;
  refined.mesh.origin_square_is_dark = mesh.origin_square_is_dark;
  CornerFitter fitter;
  forEachNode(mesh, [&](MeshNode node, const MeshCorner& corner) {
    const auto u = mesh.stepAt(node, 0);
    const auto v = mesh.stepAt(node, 1);
    if (!u || !v) return;
    const auto fit = fitter.fit(image, {.pixel = corner.pixel, .step_u = *u, .step_v = *v});
    if (!fit || (fit->contrast > 0) != mesh.squareIsDark(node)) return;
    refined.mesh.insert(node, {.pixel = fit->pixel, .contrast = std::abs(fit->contrast)});
    refined.fits.emplace_back(node, *fit);
  });
  return refined;
}

bool isRegular(const CornerMesh& mesh) {
  bool is_regular = true;
  forEachNode(mesh, [&](MeshNode node, const MeshCorner& corner) {
    const MeshCorner* right = mesh.find(step(node, 0));
    const MeshCorner* below = mesh.find(step(node, 1));
    if (right != nullptr && below != nullptr &&
        !(turn(right->pixel - corner.pixel, below->pixel - corner.pixel) > 0))
      is_regular = false;
    const auto predicted = mesh.predict(node);
    const auto u = mesh.stepAt(node, 0);
    const auto v = mesh.stepAt(node, 1);
    constexpr double kMaxMisfit = 0.3;
    if (predicted && u && v &&
        (*predicted - corner.pixel).norm() > kMaxMisfit * std::min(u->norm(), v->norm()))
      is_regular = false;
  });
  return is_regular;
}

ViewMeasures measure(const RefinedMesh& refined, ImageSize size) {
  std::vector<double> blurs;
  std::vector<double> spacings;
  std::vector<double> tilts;
  double area = 0;
  for (const auto& [node, fit] : refined.fits) {
    blurs.push_back(fit.blur_px);
    const auto u = refined.mesh.stepAt(node, 0);
    const auto v = refined.mesh.stepAt(node, 1);
    if (!u || !v) continue;
    spacings.push_back(std::min(u->norm(), v->norm()));
    Eigen::Matrix2d steps;
    steps << *u, *v;
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(steps);
    tilts.push_back(std::acos(std::min(1.0, svd.singularValues()(1) / svd.singularValues()(0))));
    const MeshCorner* here = refined.mesh.find(node);
    const MeshCorner* right = refined.mesh.find(step(node, 0));
    const MeshCorner* below = refined.mesh.find(step(node, 1));
    const MeshCorner* across = refined.mesh.find(step(step(node, 0), 1));
    if (right != nullptr && below != nullptr && across != nullptr)
      area += 0.5 * std::abs(turn(across->pixel - here->pixel, below->pixel - right->pixel));
  }
  return {.blur_px = median(blurs),
          .spacing_px = median(spacings),
          .area_share = area / (static_cast<double>(size.width) * size.height),
          .tilt_deg = median(tilts) * 180 / std::numbers::pi};
}

}  // namespace alidade
