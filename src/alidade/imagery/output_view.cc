// SPDX-License-Identifier: MIT
#include "alidade/imagery/output_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

constexpr double kHalfTurn = std::numbers::pi;
constexpr double kPole = std::numbers::pi / 2;

}  // namespace

std::string_view projectionName(ViewProjection projection) {
  return projectionNames()[static_cast<std::size_t>(projection)];
}

const std::vector<std::string>& projectionNames() {
  static const std::vector<std::string> names = {"rectilinear", "cylindrical", "equirectangular"};
  return names;
}

ViewProjection projectionOf(std::string_view name) {
  const auto at = std::find(projectionNames().begin(), projectionNames().end(), name);
  if (at != projectionNames().end()) return static_cast<ViewProjection>(at - projectionNames().begin());
  throw usageError({.where = "projection",
                    .found = "'" + std::string(name) + "'",
                    .expected = "one of " + join(projectionNames(), ", "),
                    .next_step = didYouMean(name, projectionNames())});
}

std::optional<Eigen::Vector2d> planeFromRay(ViewProjection projection, const Eigen::Vector3d& ray) {
  if (!ray.allFinite()) return std::nullopt;
  const double across = std::hypot(ray.x(), ray.z());
  switch (projection) {
    case ViewProjection::kRectilinear:
      if (!(ray.z() > 0)) return std::nullopt;
      return Eigen::Vector2d(ray.x() / ray.z(), ray.y() / ray.z());
    case ViewProjection::kCylindrical:
      if (!(across > 0)) return std::nullopt;
      return Eigen::Vector2d(std::atan2(ray.x(), ray.z()), ray.y() / across);
    case ViewProjection::kEquirectangular:
      if (!(across > 0) && ray.y() == 0) return std::nullopt;
      return Eigen::Vector2d(std::atan2(ray.x(), ray.z()), std::atan2(ray.y(), across));
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> rayFromPlane(ViewProjection projection, const Eigen::Vector2d& plane) {
  const double x = plane.x();
  const double y = plane.y();
  if (projection == ViewProjection::kRectilinear) return Eigen::Vector3d(x, y, 1);
  if (!(std::abs(x) <= kHalfTurn)) return std::nullopt;
  if (projection == ViewProjection::kCylindrical) return Eigen::Vector3d(std::sin(x), y, std::cos(x));
  if (!(std::abs(y) <= kPole)) return std::nullopt;
  return Eigen::Vector3d(std::sin(x) * std::cos(y), std::sin(y), std::cos(x) * std::cos(y));
}

void RayColumns::set(std::size_t column, const std::optional<Eigen::Vector3d>& ray) const {
  constexpr double kNoRay = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d r = ray.value_or(Eigen::Vector3d::Constant(kNoRay));
  x[column] = r.x();
  y[column] = r.y();
  z[column] = r.z();
}

void OutputView::raysOfRow(std::size_t row, const RayColumns& rays) const {
  const std::size_t width = rays.x.size();
  if (projection == ViewProjection::kRectilinear) {
    const double step = 1 / scale_px.x();
    for (std::size_t u = 0; u < width; ++u) rays.x[u] = step * (static_cast<double>(u) - axis_px.x());
    std::ranges::fill(rays.y, planeFromPixel(Eigen::Vector2d(0, row)).y());
    std::ranges::fill(rays.z, 1);
    return;
  }
  for (std::size_t u = 0; u < width; ++u) rays.set(u, rayFromPixel(Eigen::Vector2d(u, row)));
}

double OutputView::horizontalFieldRad() const {
  const double left = planeFromPixel({-0.5, axis_px.y()}).x();
  const double right = planeFromPixel({size.width - 0.5, axis_px.y()}).x();
  if (projection == ViewProjection::kRectilinear) return std::atan(right) - std::atan(left);
  return std::min(right, kHalfTurn) - std::max(left, -kHalfTurn);
}

}  // namespace alidade
