// SPDX-License-Identifier: MIT
#include "alidade/guide/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <Eigen/LU>

#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

using RayJacobian = Eigen::Matrix<double, 3, 2, Eigen::RowMajor>;

// Logarithm of the solid angle that a pixel covers; nothing without a ray.
std::optional<double> logSolidAngle(const AnyCamera& camera, const Eigen::Vector2d& pixel) {
  RayJacobian J;
  if (!camera.unproject(pixel, J.data())) return std::nullopt;
  return std::log(J.col(0).cross(J.col(1)).norm());
}

// Derivative of logSolidAngle() by the pixel; zero along an axis where a neighbour has no ray.
Eigen::Vector2d solidAngleSlope(const AnyCamera& camera, const Eigen::Vector2d& pixel) {
  Eigen::Vector2d slope(0, 0);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = Eigen::Vector2d::Unit(axis);
    const auto before = logSolidAngle(camera, pixel - step);
    const auto behind = logSolidAngle(camera, pixel + step);
    if (before && behind) slope(axis) = 0.5 * (*behind - *before);
  }
  return slope;
}

// The pose that faces the camera, upright in the image, for places where the lens's square pose is unknown.
// Any pose will do for an invalid ray.
SO3 facingPose(const Eigen::Vector3d& ray) {
  if (!ray.allFinite()) return {};
  return SO3::fromQuaternion(shortestTurn(Eigen::Vector3d::UnitZ(), ray));
}

constexpr int kCellsAlong = 8;
constexpr double kEmptyShare = 0.25;  // least share of a region's cells with corners

struct CellGrid {
  explicit CellGrid(ImageSize image) : size(image) {
    const double cell = static_cast<double>(std::max(size.width, size.height)) / kCellsAlong;
    columns = std::max(1, static_cast<int>(std::lround(size.width / cell)));
    rows = std::max(1, static_cast<int>(std::lround(size.height / cell)));
  }

  [[nodiscard]] std::size_t cellOf(const Eigen::Vector2d& pixel) const {
    const auto at = [](double c, int length, int count) {
      return static_cast<int>(std::clamp(std::floor((c + 0.5) / length * count), 0.0, count - 1.0));
    };
    return index(at(pixel.x(), size.width, columns), at(pixel.y(), size.height, rows));
  }
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row * columns + column);
  }
  [[nodiscard]] Eigen::Vector2d pixelAt(double column, double row) const {
    return {column / columns * size.width - 0.5, row / rows * size.height - 0.5};
  }
  [[nodiscard]] bool hasRay(const AnyCamera& camera, int column, int row) const {
    constexpr std::array<std::pair<double, double>, 5> kPlaces = {
        {{0.5, 0.5}, {0, 0}, {1, 0}, {0, 1}, {1, 1}}};
    return std::any_of(kPlaces.begin(), kPlaces.end(), [&](const auto& place) {
      return camera.unproject(pixelAt(column + place.first, row + place.second)).has_value();
    });
  }

  ImageSize size;
  int columns = 0;
  int rows = 0;
};

struct Share {
  int num_covered = 0;
  int num_cells = 0;

  void add(bool is_covered) {
    ++num_cells;
    if (is_covered) ++num_covered;
  }
  [[nodiscard]] double value() const {
    return num_cells == 0 ? 0.0 : static_cast<double>(num_covered) / num_cells;
  }
};

void measureCells(const AnyCamera& camera, const CellGrid& grid, CoverageReport& report) {
  Share all;
  Share border;
  std::array<Share, 9> regions;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      int& count = report.num_corners[grid.index(column, row)];
      if (count == 0 && !grid.hasRay(camera, column, row)) {
        count = -1;
        continue;
      }
      all.add(count > 0);
      const bool is_at_side = column == 0 || column == grid.columns - 1;
      const bool is_at_end = row == 0 || row == grid.rows - 1;
      if (is_at_side || is_at_end) border.add(count > 0);
      if (is_at_side && is_at_end && count > 0) ++report.num_image_corners;
      const ImageRegion region = regionAt(grid.pixelAt(column + 0.5, row + 0.5), grid.size);
      regions[static_cast<std::size_t>(3 * region.row + region.column)].add(count > 0);
    }
  }
  report.share = all.value();
  report.border_share = border.value();
  for (int i = 0; i < 9; ++i) {
    const Share& region = regions[static_cast<std::size_t>(i)];
    if (region.num_cells > 0 && region.value() < kEmptyShare)
      report.empty_regions.push_back({.column = i % 3, .row = i / 3});
  }
}

// Names as a list in a sentence: "the upper left corner, the left border and the centre".
std::string regionNames(const std::vector<ImageRegion>& regions) {
  std::string text;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if (i > 0) text += i + 1 == regions.size() ? " and " : ", ";
    text += "the " + regionName(regions[i]);
  }
  return text;
}

}  // namespace

double BoardTilt::total() const {
  return std::atan(std::hypot(std::tan(right_rad), std::tan(lower_rad)));
}

std::ptrdiff_t CoverageReport::numTilted(double angle_rad) const {
  return std::ranges::count_if(
      views, [&](const ViewCoverage& view) { return view.sighting.tilt.total() > angle_rad; });
}

std::optional<SO3> squarePose(const AnyCamera& camera, const Eigen::Vector2d& pixel) {
  RayJacobian J;
  const auto ray = camera.unproject(pixel, J.data());
  if (!ray) return std::nullopt;
  // A pixel of solid angle w sees the area w s^2 / cos(a) of a plane with normal n, at the distance s = c /
  // (n ray) along its ray, where cos(a) = n ray. The area is stationary, so that no side appears larger, if 3
  // n J = (n ray) slope of log w. With n ray = 1, this gives the part of n across the ray.
  const Eigen::Vector2d slope = solidAngleSlope(camera, pixel);
  const Eigen::Matrix2d gram = J.transpose() * J;
  Eigen::Vector3d across = J * (gram.inverse() * slope) / 3;
  // Near the rim of its domain, a lens may compress so much that only a board seen edge-on would look square.
  // Corners cannot be found on such a board.
  constexpr double kMaxTan = 1.7320508075688772;  // 60 degrees between the square pose and the facing one
  const double tan = across.norm();
  if (!std::isfinite(tan)) return facingPose(*ray);  // at a fold
  if (tan > kMaxTan) across *= kMaxTan / tan;
  const Eigen::Vector3d n = (*ray + across).normalized();
  const Eigen::Vector3d right = J.col(0) - *ray * (n.dot(J.col(0)) / n.dot(*ray));  // along the plane
  if (!right.allFinite() || right.isZero(0)) return facingPose(*ray);
  Eigen::Matrix3d R;
  R.col(2) = n;
  R.col(0) = right.normalized();
  R.col(1) = n.cross(R.col(0));
  return SO3::fromQuaternion(Eigen::Quaterniond(R));
}

BoardSighting sightBoard(const AnyCamera& camera, const Board& board, const SE3& camera_from_board) {
  BoardSighting sighting;
  const Eigen::Vector3d middle = camera_from_board * board.middle();
  sighting.middle_px = camera.projectPoint(middle).pixel;
  sighting.distance_m = middle.norm();
  const auto square = squarePose(camera, sighting.middle_px);
  const SO3 camera_from_square = square ? *square : facingPose(middle.normalized());
  const Eigen::Vector3d n =
      camera_from_square.inverse() * (camera_from_board.rotation * Eigen::Vector3d::UnitZ());
  sighting.tilt = {.right_rad = std::atan2(n.x(), n.z()), .lower_rad = std::atan2(n.y(), n.z())};
  return sighting;
}

SO3 tiltedBoard(const BoardTilt& tilt) {
  // The smallest rotation from the square pose keeps the board upright in the image. A normal that leans to
  // the right brings the right side nearer.
  return facingPose(Eigen::Vector3d(std::tan(tilt.right_rad), std::tan(tilt.lower_rad), 1).normalized());
}

std::string tiltText(const BoardTilt& tilt) {
  constexpr double kLeastDegrees = 5;
  const double across = kDegPerRad * std::abs(tilt.right_rad);
  const double along = kDegPerRad * std::abs(tilt.lower_rad);
  const bool is_across = across >= kLeastDegrees;
  const bool is_along = along >= kLeastDegrees;
  if (!is_across && !is_along) return "not tilted";
  const char* side = tilt.right_rad > 0 ? "right" : "left";
  const char* end = tilt.lower_rad > 0 ? "lower" : "upper";
  if (!is_along) return fmt::format("its {} side turned {:.0f} degrees towards the camera", side, across);
  if (!is_across) return fmt::format("its {} side turned {:.0f} degrees towards the camera", end, along);
  return fmt::format("its {} side turned {:.0f} degrees and its {} side {:.0f} degrees towards the camera",
                     side, across, end, along);
}

ImageRegion regionAt(const Eigen::Vector2d& pixel, ImageSize size) {
  const auto third = [](double at, int length) {
    return static_cast<int>(std::clamp(std::floor(3 * (at + 0.5) / length), 0.0, 2.0));
  };
  return {.column = third(pixel.x(), size.width), .row = third(pixel.y(), size.height)};
}

std::string regionName(const ImageRegion& region) {
  const std::string row = region.row == 0 ? "upper" : region.row == 2 ? "lower" : "";
  const std::string column = region.column == 0 ? "left" : region.column == 2 ? "right" : "";
  if (row.empty() && column.empty()) return "centre";
  if (row.empty() || column.empty()) return row + column + " border";
  return row + " " + column + " corner";
}

std::string placeName(const ImageRegion& region) {
  const bool is_border = (region.row == 1) != (region.column == 1);
  return (is_border ? "at the " : "in the ") + regionName(region);
}

double fillOf(const Eigen::AlignedBox2d& box, ImageSize size) {
  if (box.isEmpty()) return 0;
  return std::max(box.sizes().x() / size.width, box.sizes().y() / size.height);
}

std::vector<std::vector<Eigen::Vector2d>> usedCorners(const Calibration& calibration,
                                                      std::span<const View> views) {
  std::vector<std::vector<Eigen::Vector2d>> used;
  for (const FitView& view : calibration.fit.views) {
    expect(view.source < views.size() && views[view.source].image == view.image,
           "the views are those of the calibration");
    used.push_back(mapped(view.corners, &Observation::pixel));
  }
  return used;
}

CoverageReport imageCoverage(const AnyCamera& camera, ImageSize size,
                             std::span<const std::vector<Eigen::Vector2d>> corners) {
  const CellGrid grid(size);
  CoverageReport report;
  report.columns = grid.columns;
  report.rows = grid.rows;
  report.num_corners.assign(grid.index(0, grid.rows), 0);
  for (const std::vector<Eigen::Vector2d>& of_view : corners)
    for (const Eigen::Vector2d& pixel : of_view) ++report.num_corners[grid.cellOf(pixel)];
  measureCells(camera, grid, report);
  return report;
}

CoverageReport coverageOf(const Calibration& calibration, std::span<const View> views) {
  const AnyCamera camera = calibration.camera();
  const Fit& fit = calibration.fit;
  const auto corners = usedCorners(calibration, views);
  CoverageReport report = imageCoverage(camera, calibration.imageSize(), corners);
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& pixel : corners[v]) box.extend(pixel);
    const FitView& view = fit.views[v];
    report.views.push_back(
        {.image = view.image,
         .board = view.board,
         .sighting = sightBoard(camera, boardOf(fit, view).target, cameraFromBoard(fit, view)),
         .fill = fillOf(box, calibration.imageSize())});
    const BoardTilt& tilt = report.views.back().sighting.tilt;
    const std::array<double, 4> nearer_rad = {-tilt.right_rad, tilt.right_rad, -tilt.lower_rad,
                                              tilt.lower_rad};
    for (std::size_t side = 0; side < nearer_rad.size(); ++side)
      report.num_tilted_to[side] += nearer_rad[side] > kTiltedRad ? 1 : 0;
  }
  if (report.views.empty()) return report;
  const auto distances = std::ranges::minmax(
      mapped(report.views, [](const ViewCoverage& view) { return view.sighting.distance_m; }));
  report.nearest_m = distances.min;
  report.farthest_m = distances.max;
  return report;
}

std::string coverageText(const CoverageReport& report) {
  std::string text = fmt::format(
      "board corners in {:.0f} % of the image and in {} of the 4 image corners; {} of {} views tilted by "
      "more than 15 degrees, {} by more than 30; distances {:.3g} to {:.3g} m\n",
      100 * report.share, report.num_image_corners, report.numTilted(kTiltedRad), report.views.size(),
      report.numTilted(kSteepRad), report.nearest_m, report.farthest_m);
  if (!report.empty_regions.empty())
    text += "almost no board corners in " + regionNames(report.empty_regions) + " of the image\n";
  std::vector<std::string> sides;
  for (std::size_t side = 0; side < kSideNames.size(); ++side)
    if (report.num_tilted_to[side] == 0) sides.emplace_back(kSideNames[side]);
  if (!sides.empty())
    text += fmt::format(
        "sides of the board that no view has turned towards the camera by more than 15 degrees: {}\n",
        join(sides, ", "));
  return text;
}

}  // namespace alidade
