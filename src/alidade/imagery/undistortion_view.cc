// SPDX-License-Identifier: MIT
#include "alidade/imagery/undistortion_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "alidade/core/error.h"
#include "alidade/imagery/view_search.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

OutputView centredView(ViewProjection projection, ImageSize size, double scale_px) {
  return {.projection = projection,
          .size = size,
          .scale_px = Vector2d::Constant(scale_px),
          .axis_px = detail::middleOf(size)};
}

OutputView sameScale(const AnyCamera& camera, ImageSize source_size, ViewProjection projection,
                     ImageSize size) {
  // Pixels per radian on the axis. They differ from the parameters fx and fy in models whose lens also scales
  // the image.
  std::array<double, 6> J{};
  const Projection axis = camera.project(Vector3d::UnitZ(), J.data(), nullptr);
  if (!axis.ok() || !(J[0] > 0 && J[4] > 0)) {
    throw inputError({.where = "camera",
                      .found = "a camera that cannot project its optical axis",
                      .expected = "a camera that sees along its axis",
                      .next_step = "run alidade validate for details"});
  }
  const double resize = static_cast<double>(size.width) / source_size.width;
  OutputView view{
      .projection = projection, .size = size, .scale_px = resize * Vector2d(J[0], J[4]), .axis_px = {}};
  if (projection != ViewProjection::kRectilinear)
    view.scale_px.setConstant(std::sqrt(view.scale_px.x() * view.scale_px.y()));
  // A change of the height is split between top and bottom.
  const Vector2d half(0.5, 0.5);
  view.axis_px = resize * (axis.pixel + half) - half;
  view.axis_px.y() += 0.5 * (size.height - resize * source_size.height);
  return view;
}

OutputView fieldOfView(ViewProjection projection, ImageSize size, double field_rad) {
  const bool is_flat = projection == ViewProjection::kRectilinear;
  const double largest = is_flat ? 2 * kMaxTangentAngleRad : 2 * std::numbers::pi;
  constexpr double kRounding = 1e-12;  // from the conversion of degrees to radians
  if (!(field_rad > 0 && field_rad <= largest * (1 + kRounding))) {
    constexpr double kDegrees = 180 / std::numbers::pi;
    throw usageError(
        {.where = "field of view",
         .found = std::to_string(field_rad * kDegrees) + " degrees",
         .expected = is_flat ? "more than 0 and at most 150 degrees in a rectilinear view"
                             : "more than 0 and at most 360 degrees",
         .next_step =
             is_flat ? "use a cylindrical or equirectangular projection for a larger field of view" : ""});
  }
  const double half_width = is_flat ? std::tan(field_rad / 2) : field_rad / 2;
  return centredView(projection, size, 0.5 * size.width / half_width);
}

ViewChoice validView(const AnyCamera& camera, ImageSize source_size, ViewProjection projection,
                     ImageSize size) {
  const auto has_source = [&](const Vector2d& plane) {
    const auto ray = rayFromPlane(projection, plane);
    if (!ray) return false;
    const Projection source = camera.project(*ray);
    return source.ok() && detail::isBetweenPixelCentres(source.pixel, source_size);
  };
  if (!has_source(Vector2d::Zero())) {
    throw inputError({.where = "camera",
                      .found = "an optical axis outside the image",
                      .expected = "an optical axis inside the image",
                      .next_step = "use --keep all, or set the field of view with --fov"});
  }
  double limit = std::numeric_limits<double>::infinity();
  for (const Vector2d& offset : detail::borderOffsets(size))
    limit = std::min(limit, detail::farthestMultiple(projection, offset));
  const double best = detail::largestWindow(size, limit, has_source);
  constexpr double kMargin = 1e-9;  // for rounding of pixel positions
  return {.view = centredView(projection, size, (1 + kMargin) / best),
          .cut_share = 0,
          .is_limited_by_projection = best == limit};
}

ViewChoice viewOfAll(const AnyCamera& camera, ImageSize source_size, ViewProjection projection,
                     ImageSize size) {
  const detail::PlaneBox box = detail::boxOfAll(camera, source_size, [&](const Vector3d& ray) {
    const auto plane = planeFromRay(projection, ray);
    return plane && detail::isLaidOut(projection, *plane) ? plane : std::nullopt;
  });
  const Vector2d extent = box.shown.sizes();
  if (!(extent.minCoeff() > 0)) {
    throw inputError({.where = "camera",
                      .found = "almost no pixel with a ray that this projection can show",
                      .expected = "a camera that looks forward",
                      .next_step = "run alidade validate for details"});
  }
  constexpr double kMargin = 1e-9;  // for rounding of pixel positions
  const double scale =
      (1 - kMargin) * std::min((size.width - 1) / extent.x(), (size.height - 1) / extent.y());
  OutputView view = centredView(projection, size, scale);
  view.axis_px -= scale * box.shown.center();
  return {.view = view,
          .cut_share = static_cast<double>(box.num_cut) / std::max(1, box.num_shown + box.num_cut),
          .is_limited_by_projection = box.num_cut > 0};
}

}  // namespace

ViewChoice chooseView(const AnyCamera& camera, ImageSize source_size, const ViewRequest& request) {
  const ImageSize size = request.size.value_or(source_size);
  detail::checkViewSizes(source_size, size);
  switch (request.extent) {
    case ViewExtent::kSameScale:
      return {.view = sameScale(camera, source_size, request.projection, size)};
    case ViewExtent::kFieldOfView:
      return {.view = fieldOfView(request.projection, size, request.horizontal_field_rad)};
    case ViewExtent::kValid:
      return validView(camera, source_size, request.projection, size);
    case ViewExtent::kAll:
      return viewOfAll(camera, source_size, request.projection, size);
  }
  return {};
}

AnyCamera pinholeOf(const OutputView& view) {
  expect(view.projection == ViewProjection::kRectilinear, "only a rectilinear view is a pinhole camera's");
  const std::array<double, 4> params = {view.scale_px.x(), view.scale_px.y(), view.axis_px.x(),
                                        view.axis_px.y()};
  return AnyCamera::make("pinhole", params);
}

}  // namespace alidade
