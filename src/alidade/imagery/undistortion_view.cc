// SPDX-License-Identifier: MIT
#include "alidade/imagery/undistortion_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "alidade/camera/pinhole.h"
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
  const auto [axis, focal] = detail::axisOf(camera, "camera", "run alidade validate for details");
  const double resize = static_cast<double>(size.width) / source_size.width;
  OutputView view{.projection = projection, .size = size, .scale_px = resize * focal, .axis_px = {}};
  if (projection != ViewProjection::kRectilinear)
    view.scale_px.setConstant(std::sqrt(view.scale_px.x() * view.scale_px.y()));
  // A change of the height is split between top and bottom.
  const Vector2d half(0.5, 0.5);
  view.axis_px = resize * (axis + half) - half;
  view.axis_px.y() += 0.5 * (size.height - resize * source_size.height);
  return view;
}

OutputView fieldOfView(ViewProjection projection, ImageSize size, double field_rad) {
  const bool is_flat = projection == ViewProjection::kRectilinear;
  const double largest = is_flat ? 2 * kMaxTangentAngleRad : 2 * std::numbers::pi;
  const double half_width =
      detail::halfWidthOf(field_rad, is_flat, largest,
                          is_flat ? "more than 0 and at most 150 degrees in a rectilinear view"
                                  : "more than 0 and at most 360 degrees",
                          "use a cylindrical or equirectangular projection for a larger field of view");
  return centredView(projection, size, 0.5 * size.width / half_width);
}

// The middle of the largest window without a place that has no source. The ends of lines from `start` stand
// for all such places: a window reaches to the first of them.
template <class HasSource>
Vector2d centreOfLargest(ViewProjection projection, ImageSize size, const Vector2d& start,
                         const HasSource& has_source) {
  constexpr int kNumEnds = 360;
  const Vector2d half = detail::middleOf(size);
  const auto fromStart = [&](const Vector2d& offset) { return has_source(start + offset); };
  std::vector<Vector2d> ends;
  for (int i = 0; i < kNumEnds; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / kNumEnds;
    const std::array<Vector2d, 1> offset = {
        half.cwiseProduct(Vector2d(std::cos(azimuth), std::sin(azimuth)))};
    const double limit = 2 * detail::farthestMultiple(projection, offset[0]);
    ends.emplace_back(start + detail::largestWindow(offset, limit, fromStart) * offset[0]);
  }
  const auto sizeAt = [&](const Vector2d& centre) {
    double least = std::numeric_limits<double>::infinity();
    for (const Vector2d& end : ends)
      least = std::min(least, (end - centre).cwiseAbs().cwiseQuotient(half).maxCoeff());
    return least;
  };
  // A grid that closes in on its best node.
  constexpr int kNumRounds = 24;
  constexpr double kShrink = 0.6;
  constexpr int kNodes = 2;  // to each side
  Vector2d best = start;
  double largest = sizeAt(start);
  Vector2d step = largest / kNodes * half;
  for (int round = 0; round < kNumRounds; ++round, step *= kShrink) {
    const Vector2d middle = best;
    for (int y = -kNodes; y <= kNodes; ++y) {
      for (int x = -kNodes; x <= kNodes; ++x) {
        const Vector2d centre = middle + step.cwiseProduct(Vector2d(x, y));
        const double reached = sizeAt(centre);
        if (reached <= largest || !has_source(centre)) continue;
        largest = reached;
        best = centre;
      }
    }
  }
  return best;
}

ViewChoice validView(const AnyCamera& camera, ImageSize source_size, ViewProjection projection,
                     ImageSize size) {
  const auto has_source = [&](const Vector2d& plane) {
    if (!detail::isLaidOut(projection, plane)) return false;
    const auto ray = rayFromPlane(projection, plane);
    if (!ray) return false;
    const Projection source = camera.project(*ray);
    return source.ok() && detail::isBetweenPixelCentres(source.pixel, source_size);
  };
  const auto ray = camera.unproject(detail::middleOf(source_size));
  const Vector2d start = (ray ? planeFromRay(projection, *ray) : std::nullopt).value_or(Vector2d::Zero());
  if (!has_source(start)) {
    throw inputError({.where = "camera",
                      .found = "no ray in the middle of the image, or one that this projection cannot show",
                      .expected = "a camera that looks forward",
                      .next_step = "use --keep all, or set the field of view with --fov"});
  }
  const Vector2d centre = centreOfLargest(projection, size, start, has_source);
  const std::vector<Vector2d> offsets = detail::borderOffsets(size);
  const double best =
      detail::largestWindow(offsets, 2 * detail::farthestMultiple(projection, detail::middleOf(size)),
                            [&](const Vector2d& offset) { return has_source(centre + offset); });
  constexpr double kMargin = 1e-9;  // for rounding of pixel positions
  OutputView view = centredView(projection, size, (1 + kMargin) / best);
  view.axis_px -= view.scale_px.cwiseProduct(centre);
  constexpr double kBeyond = 1 + 1e-6;
  return {.view = view,
          .cut_share = 0,
          .is_limited_by_projection = std::ranges::any_of(offsets, [&](const Vector2d& offset) {
            return !detail::isLaidOut(projection, centre + kBeyond * best * offset);
          })};
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
  const double scale = detail::scaleOfAll(size, extent);
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
  return AnyCamera::make(Pinhole::kId, params);
}

}  // namespace alidade
