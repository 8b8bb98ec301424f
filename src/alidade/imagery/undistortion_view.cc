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
#include "alidade/core/size_groups.h"
#include "alidade/imagery/remap.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const double kMaxTangent = std::tan(kMaxTangentAngleRad);

// How far from the axis an image may be laid out on the plane of a view that is not rectilinear.
Vector2d limitsOf(ViewProjection projection) {
  return {std::numbers::pi, projection == ViewProjection::kCylindrical ? kMaxTangent : std::numbers::pi / 2};
}

Vector2d middleOf(ImageSize size) {
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

OutputView centredView(ViewProjection projection, ImageSize size, double scale_px) {
  return {.projection = projection,
          .size = size,
          .scale_px = Vector2d::Constant(scale_px),
          .axis_px = middleOf(size)};
}

OutputView sameScale(const AnyCamera& camera, ImageSize source_size, ViewProjection projection,
                     ImageSize size) {
  // The pixels per radian where the axis appears. Not the parameters fx and fy, which some models share out
  // with their lens.
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
  // What the size adds or takes away of the height is shared by top and bottom.
  const Vector2d half(0.5, 0.5);
  view.axis_px = resize * (axis.pixel + half) - half;
  view.axis_px.y() += 0.5 * (size.height - resize * source_size.height);
  return view;
}

OutputView fieldOfView(ViewProjection projection, ImageSize size, double field_rad) {
  const bool is_flat = projection == ViewProjection::kRectilinear;
  const double largest = is_flat ? 2 * kMaxTangentAngleRad : 2 * std::numbers::pi;
  constexpr double kRounding = 1e-12;  // of degrees turned into radians
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

// Offsets of the border pixels' centres from the middle of an image.
std::vector<Vector2d> borderOffsets(ImageSize size) {
  const Vector2d middle = middleOf(size);
  std::vector<Vector2d> offsets;
  for (int x = 0; x < size.width; ++x) {
    offsets.emplace_back(x - middle.x(), -middle.y());
    offsets.emplace_back(x - middle.x(), middle.y());
  }
  for (int y = 1; y + 1 < size.height; ++y) {
    offsets.emplace_back(-middle.x(), y - middle.y());
    offsets.emplace_back(middle.x(), y - middle.y());
  }
  return offsets;
}

ViewChoice validView(const AnyCamera& camera, ImageSize source_size, ViewProjection projection,
                     ImageSize size) {
  const Vector2d last(source_size.width - 1, source_size.height - 1);
  const auto has_source = [&](const Vector2d& plane) {
    const auto ray = rayFromPlane(projection, plane);
    if (!ray) return false;
    const Projection source = camera.project(*ray);
    return source.ok() && (source.pixel.array() >= 0).all() && (source.pixel.array() <= last.array()).all();
  };
  if (!has_source(Vector2d::Zero())) {
    throw inputError({.where = "camera",
                      .found = "an optical axis outside the image",
                      .expected = "an optical axis inside the image",
                      .next_step = "use --keep all, or set the field of view with --fov"});
  }
  const std::vector<Vector2d> offsets = borderOffsets(size);
  // The largest units of the plane per pixel at which the whole window is within the limits.
  double limit = std::numeric_limits<double>::infinity();
  for (const Vector2d& offset : offsets) {
    limit = std::min(limit, projection == ViewProjection::kRectilinear
                                ? kMaxTangent / offset.norm()
                                : limitsOf(projection).cwiseQuotient(offset.cwiseAbs()).minCoeff());
  }
  double best = limit;
  for (const Vector2d& offset : offsets) {
    constexpr int kNumSteps = 64;  // a lens that loses a line for less than a step of it is none
    for (int i = 1; i <= kNumSteps; ++i) {
      const double step = best / kNumSteps;
      if (has_source(i * step * offset)) continue;
      double good = (i - 1) * step;
      double bad = i * step;
      constexpr double kRelative = 1e-12;
      while (bad - good > kRelative * bad) {
        const double middle = 0.5 * (good + bad);
        (has_source(middle * offset) ? good : bad) = middle;
      }
      best = good;
      break;
    }
  }
  constexpr double kMargin = 1e-9;  // against the rounding of pixels' places
  return {.view = centredView(projection, size, (1 + kMargin) / best),
          .cut_share = 0,
          .is_limited_by_projection = best == limit};
}

// The part of the plane that source pixels fill.
struct PlaneBox {
  Eigen::AlignedBox2d shown;
  int num_shown = 0;
  int num_cut = 0;
};

// What becomes of a source pixel; its place on the plane if it is shown.
struct SourceNode {
  bool has_ray = false;
  std::optional<Vector2d> plane;
};

// True if pixels between these may lie farther out than these: where rays end or are cut, and where angles
// jump from half a turn on one side to half a turn on the other.
bool needsAllPixels(const std::array<const SourceNode*, 4>& corners) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  int num_shown = 0;
  for (const SourceNode* node : corners) {
    if (!node->plane) continue;
    ++num_shown;
    low = std::min(low, node->plane->x());
    high = std::max(high, node->plane->x());
  }
  constexpr double kJump = 1;  // radians, or tangents, which differ by less between neighbours but at the rim
  return num_shown > 0 && (num_shown < 4 || high - low > kJump);
}

// Looks at all border pixels, at every 16th pixel inside, and at all pixels where that is not enough.
// Elsewhere it is: a place with shown pixels all around is not an extreme one.
PlaneBox boxOfAll(const AnyCamera& camera, ImageSize size, ViewProjection projection) {
  constexpr int kStride = 16;
  PlaneBox box;
  const auto is_within_limits = [&](const Vector2d& plane) {
    if (projection == ViewProjection::kRectilinear) return plane.norm() <= kMaxTangent;
    return (plane.cwiseAbs().array() <= limitsOf(projection).array()).all();
  };
  const auto look = [&](const Vector2d& pixel) {
    SourceNode node;
    const auto ray = camera.unproject(pixel);
    if (!ray) return node;
    node.has_ray = true;
    node.plane = planeFromRay(projection, *ray);
    if (node.plane && !is_within_limits(*node.plane)) node.plane.reset();
    if (node.plane) box.shown.extend(*node.plane);
    return node;
  };
  const auto places = [](int length) {
    std::vector<int> at;
    for (int i = 0; i < length - 1; i += kStride) at.push_back(i);
    at.push_back(length - 1);
    return at;
  };
  const std::vector<int> xs = places(size.width);
  const std::vector<int> ys = places(size.height);
  std::vector<std::vector<SourceNode>> nodes(ys.size(), std::vector<SourceNode>(xs.size()));
  for (std::size_t j = 0; j < ys.size(); ++j) {
    for (std::size_t i = 0; i < xs.size(); ++i) {
      const SourceNode& node = nodes[j][i] = look(Vector2d(xs[i], ys[j]));
      if (node.has_ray) ++(node.plane ? box.num_shown : box.num_cut);
    }
  }
  for (const Vector2d& offset : borderOffsets(size)) look(middleOf(size) + offset);
  for (std::size_t j = 1; j < ys.size(); ++j) {
    for (std::size_t i = 1; i < xs.size(); ++i) {
      if (!needsAllPixels({&nodes[j - 1][i - 1], &nodes[j - 1][i], &nodes[j][i - 1], &nodes[j][i]})) continue;
      for (int y = ys[j - 1]; y <= ys[j]; ++y) {
        for (int x = xs[i - 1]; x <= xs[i]; ++x) look(Vector2d(x, y));
      }
    }
  }
  return box;
}

ViewChoice viewOfAll(const AnyCamera& camera, ImageSize source_size, ViewProjection projection,
                     ImageSize size) {
  const PlaneBox box = boxOfAll(camera, source_size, projection);
  const Vector2d extent = box.shown.sizes();
  if (!(extent.minCoeff() > 0)) {
    throw inputError({.where = "camera",
                      .found = "almost no pixel with a ray that this projection can show",
                      .expected = "a camera that looks forward",
                      .next_step = "run alidade validate for details"});
  }
  constexpr double kMargin = 1e-9;  // against the rounding of pixels' places
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
  constexpr std::int64_t kMaxPixels = std::int64_t{1} << 28;
  const std::string max_side = std::to_string(kMaxRemapSide);
  if (std::max(source_size.width, source_size.height) > kMaxRemapSide) {
    throw inputError({.where = "image size of the camera",
                      .found = sizeText(source_size),
                      .expected = "sides of at most " + max_side + " pixels"});
  }
  if (std::min(size.width, size.height) < 2 || std::max(size.width, size.height) > kMaxRemapSide ||
      std::int64_t{size.width} * size.height > kMaxPixels) {
    throw usageError({.where = "output size",
                      .found = sizeText(size),
                      .expected = "sides of 2 to " + max_side + " pixels, and at most " +
                                  std::to_string(kMaxPixels) + " in total"});
  }
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
