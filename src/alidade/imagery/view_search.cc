// SPDX-License-Identifier: MIT
#include "alidade/imagery/view_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>

#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/imagery/remap.h"

namespace alidade::detail {
namespace {

using Eigen::Vector2d;

const double kMaxTangent = std::tan(kMaxTangentAngleRad);

// Farthest place from the axis that a view which is not rectilinear may show.
Vector2d limitsOf(ViewProjection projection) {
  return {std::numbers::pi, projection == ViewProjection::kCylindrical ? kMaxTangent : std::numbers::pi / 2};
}

// A source pixel, and its place on the plane if it is shown.
struct SourceNode {
  bool has_ray = false;
  std::optional<Vector2d> plane;
};

// True if pixels between these four may lie farther out than they do: where rays end or are cut, and where
// angles jump by a full turn.
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
  constexpr double kJump = 1;  // radians, or tangents; neighbours differ by less, except at the rim
  return num_shown > 0 && (num_shown < 4 || high - low > kJump);
}

}  // namespace

bool isLaidOut(ViewProjection projection, const Vector2d& plane) {
  if (projection == ViewProjection::kRectilinear) return plane.norm() <= kMaxTangent;
  return (plane.cwiseAbs().array() <= limitsOf(projection).array()).all();
}

double farthestMultiple(ViewProjection projection, const Vector2d& offset) {
  return projection == ViewProjection::kRectilinear
             ? kMaxTangent / offset.norm()
             : limitsOf(projection).cwiseQuotient(offset.cwiseAbs()).minCoeff();
}

Vector2d middleOf(ImageSize size) {
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

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

void checkViewSizes(ImageSize source_size, ImageSize size) {
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
}

std::pair<Vector2d, Vector2d> axisOf(const AnyCamera& camera, const std::string& where,
                                     const std::string& next_step) {
  std::array<double, 6> J{};
  const Projection axis = camera.project(Eigen::Vector3d::UnitZ(), J.data(), nullptr);
  if (axis.ok() && J[0] > 0 && J[4] > 0) return {axis.pixel, {J[0], J[4]}};
  throw inputError({.where = where,
                    .found = "a camera that cannot project its optical axis",
                    .expected = "a camera that sees along its axis",
                    .next_step = next_step});
}

double halfWidthOf(double field_rad, bool is_flat, double largest_rad, const std::string& expected,
                   const std::string& next_step) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  constexpr double kRounding = 1e-12;  // from the conversion of degrees to radians
  if (field_rad > 0 && field_rad <= largest_rad * (1 + kRounding))
    return is_flat ? std::tan(field_rad / 2) : field_rad / 2;
  throw usageError({.where = "field of view",
                    .found = std::to_string(field_rad * kDegrees) + " degrees",
                    .expected = expected,
                    .next_step = is_flat ? next_step : ""});
}

double scaleOfAll(ImageSize size, const Vector2d& extent) {
  constexpr double kMargin = 1e-9;  // for rounding of pixel positions
  return (1 - kMargin) * std::min((size.width - 1) / extent.x(), (size.height - 1) / extent.y());
}

PlaneBox boxOfAll(const AnyCamera& camera, ImageSize size, const PlaneOfRay& plane_of) {
  constexpr int kStride = 16;
  PlaneBox box;
  const auto look = [&](const Vector2d& pixel) {
    SourceNode node;
    const auto ray = camera.unproject(pixel);
    if (!ray) return node;
    node.has_ray = true;
    node.plane = plane_of(*ray);
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

double largestWindow(std::span<const Vector2d> offsets, double limit,
                     const std::function<bool(const Vector2d&)>& has_source) {
  double best = limit;
  for (const Vector2d& offset : offsets) {
    constexpr int kNumSteps = 64;  // assumes that no lens lacks rays for less than one step of a line
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
  return best;
}

bool isBetweenPixelCentres(const Vector2d& pixel, ImageSize size) {
  const Vector2d last(size.width - 1, size.height - 1);
  return (pixel.array() >= 0).all() && (pixel.array() <= last.array()).all();
}

}  // namespace alidade::detail
