// SPDX-License-Identifier: MIT
#include "alidade/compare/rig_difference.h"

#include <algorithm>
#include <cmath>

#include "alidade/core/error.h"
#include "alidade/core/statistics.h"

namespace alidade {
namespace {

constexpr int kLongerSide = 40;      // pixels of the grid
constexpr double kLeastShare = 0.1;  // of the grid's pixels
constexpr double kUsualBaselines = 10;
constexpr double kUsualDistance = 1;  // m, for cameras at one place

std::vector<Eigen::Vector2d> gridOf(ImageSize size) {
  const double step = static_cast<double>(std::max(size.width, size.height)) / kLongerSide;
  const int columns = std::max(1, static_cast<int>(std::lround(size.width / step)));
  const int rows = std::max(1, static_cast<int>(std::lround(size.height / step)));
  std::vector<Eigen::Vector2d> grid;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      grid.emplace_back((column + 0.5) * size.width / columns - 0.5, (row + 0.5) * size.height / rows - 0.5);
    }
  }
  return grid;
}

// Pixel of `to` for the point that `from` sees at `pixel` and at a distance; nothing outside the image.
std::optional<Eigen::Vector2d> transferred(const RigCameraRecord& from, const RigCameraRecord& to,
                                           const SE3& to_from_from, const Eigen::Vector2d& pixel,
                                           double distance_m) {
  const auto ray = from.camera.camera.unproject(pixel);
  if (!ray) return std::nullopt;
  const Projection seen =
      to.camera.camera.projectPoint(to_from_from * (from.camera.camera.startOf(*ray) + distance_m * *ray));
  const bool is_inside = seen.ok() && seen.pixel.x() >= -0.5 && seen.pixel.y() >= -0.5 &&
                         seen.pixel.x() < to.camera.image_size.width - 0.5 &&
                         seen.pixel.y() < to.camera.image_size.height - 0.5;
  return is_inside ? std::optional(seen.pixel) : std::nullopt;
}

std::optional<TransferDifference> transferDifference(std::span<const RigCameraRecord> a,
                                                     std::span<const RigCameraRecord> b, std::size_t from,
                                                     std::size_t to, double distance_m) {
  TransferDifference result{.from = from, .to = to};
  const SE3 a_to_from = a[to].camera_from_rig * a[from].camera_from_rig.inverse();
  const SE3 b_to_from = b[to].camera_from_rig * b[from].camera_from_rig.inverse();
  const std::vector<Eigen::Vector2d> grid = gridOf(a[from].camera.image_size);
  std::vector<double> lengths;
  double sum_of_squares = 0;
  for (const Eigen::Vector2d& pixel : grid) {
    const auto in_a = transferred(a[from], a[to], a_to_from, pixel, distance_m);
    const auto in_b = transferred(b[from], b[to], b_to_from, pixel, distance_m);
    if (!in_a || !in_b) continue;
    const double length = (*in_a - *in_b).norm();
    if (lengths.empty() || length > result.max_px) {
      result.max_px = length;
      result.worst_pixel = pixel;
    }
    sum_of_squares += length * length;
    lengths.push_back(length);
  }
  result.num_compared = static_cast<int>(lengths.size());
  if (static_cast<double>(lengths.size()) < kLeastShare * static_cast<double>(grid.size()))
    return std::nullopt;
  result.rms_px = std::sqrt(sum_of_squares / static_cast<double>(lengths.size()));
  result.p95_px = quantile95(std::move(lengths));
  return result;
}

}  // namespace

double usualDistance(std::span<const RigCameraRecord> rig) {
  double longest = 0;
  for (const RigCameraRecord& one : rig) {
    const SE3 rig_from_one = one.camera_from_rig.inverse();
    for (const RigCameraRecord& other : rig)
      longest = std::max(longest, (other.camera_from_rig * rig_from_one).translation.norm());
  }
  return longest > 0 && std::isfinite(longest) ? kUsualBaselines * longest : kUsualDistance;
}

RigDifference rigDifference(std::span<const RigCameraRecord> a, std::span<const RigCameraRecord> b,
                            double distance_m) {
  expect(a.size() == b.size() && a.size() > 1, "two rigs of the same cameras");
  expect(distance_m > 0 && std::isfinite(distance_m), "points at a distance");
  RigDifference result{.distance_m = distance_m, .places = {}, .transfers = {}};
  for (std::size_t to = 0; to < a.size(); ++to) {
    const SE3 first_from_a = a[0].camera_from_rig * a[to].camera_from_rig.inverse();
    const SE3 first_from_b = b[0].camera_from_rig * b[to].camera_from_rig.inverse();
    result.places.push_back(
        {.distance_m = (first_from_a.translation - first_from_b.translation).norm(),
         .angle_rad = (first_from_a.rotation.inverse() * first_from_b.rotation).log().norm()});
    std::optional<TransferDifference> worst;
    for (std::size_t from = 0; from < a.size(); ++from) {
      if (from == to) continue;
      const auto one = transferDifference(a, b, from, to, distance_m);
      if (one && (!worst || one->p95_px > worst->p95_px)) worst = one;
    }
    result.transfers.push_back(worst);
  }
  return result;
}

}  // namespace alidade
