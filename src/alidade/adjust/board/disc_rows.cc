// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/disc_rows.h"

#include <algorithm>
#include <array>

#include "alidade/geometry/curve_centroid.h"

namespace alidade::detail {
namespace {

constexpr std::size_t kRimPoints = 12;
static_assert(kRimPoints % kNumLanes == 0);
using Rim = std::array<CornerGroup, kRimPoints / kNumLanes>;
using RimPixels = Eigen::Matrix<double, 2, static_cast<int>(kRimPoints)>;

// The rim as corners seen at pixel (0, 0), so that their errors are their pixels.
Rim rimOf(const CornerGroup& group, std::size_t lane) {
  static const RimPixels circle = unitCircle<static_cast<int>(kRimPoints)>();
  Rim rim;
  for (std::size_t i = 0; i < kRimPoints; ++i) {
    CornerGroup& to = rim[i / kNumLanes];
    const std::size_t l = i % kNumLanes;
    const auto place = static_cast<Eigen::Index>(i);
    to.x[l] = group.x[lane] + group.radius_m * circle(0, place);
    to.y[l] = group.y[lane] + group.radius_m * circle(1, place);
    to.z[l] = group.z[lane];
    to.u[l] = to.v[l] = 0;
    to.root_weight[l] = 1;
    to.radius_m = 0;
  }
  return rim;
}

}  // namespace

Eigen::Vector2d DiscRows::error(const CornerGroup& group, std::size_t lane) const {
  const Rim rim = rimOf(group, lane);
  std::array<Eigen::Vector2d, kRimPoints> pixels;
  points_.errors(params_, camera_from_board_, rim, pixels);
  RimPixels seen;
  for (std::size_t i = 0; i < kRimPoints; ++i) seen.col(static_cast<Eigen::Index>(i)) = pixels[i];
  return centroidWithin(seen).at - Eigen::Vector2d(group.u[lane], group.v[lane]);
}

bool DiscRows::write(const CornerGroup& group, std::size_t lane, double* rows) const {
  constexpr auto kRows = static_cast<int>(2 * kRimPoints);
  const auto size = static_cast<int>(points_.layout().size);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kRows,
                                 static_cast<int>(kMaxColumns)>;
  RowMajor of_rim(kRows, size);
  const Rim rim = rimOf(group, lane);
  points_.rows(params_, camera_from_board_, rim,
               std::span(of_rim.data(), static_cast<std::size_t>(kRows * size)));
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> to(rows, 2, size);
  // A point that projects has derivative 1 by the image's centre.
  constexpr int kCentreX = 6 + 2;
  for (int i = 0; i < kRows; i += 2) {
    if (of_rim(i, kCentreX) != 0) continue;
    to.setZero();
    return false;
  }
  RimPixels seen;
  for (int i = 0; i < static_cast<int>(kRimPoints); ++i)
    seen.col(i) << of_rim(2 * i, size - 1), of_rim(2 * i + 1, size - 1);
  const auto centroid = centroidWithin(seen);
  // Column by column: u and v of each point alternate, like the rows.
  to.row(0).noalias() = centroid.J_x_points.reshaped().transpose() * of_rim;
  to.row(1).noalias() = centroid.J_y_points.reshaped().transpose() * of_rim;
  to(0, size - 1) = centroid.at.x() - group.u[lane];
  to(1, size - 1) = centroid.at.y() - group.v[lane];
  return true;
}

}  // namespace alidade::detail
