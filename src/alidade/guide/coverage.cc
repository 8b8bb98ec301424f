// SPDX-License-Identifier: MIT
#include "alidade/guide/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"

namespace alidade {
namespace {

constexpr int kCellsAlong = 8;
constexpr double kEmptyShare = 0.25;  // of a region's cells: fewer hold corners

// The cells, and which of them can be seen at all.
struct CellGrid {
  CellGrid(const AnyCamera& camera, ImageSize image) : size(image) {
    const double cell = static_cast<double>(std::max(size.width, size.height)) / kCellsAlong;
    columns = std::max(1, static_cast<int>(std::lround(size.width / cell)));
    rows = std::max(1, static_cast<int>(std::lround(size.height / cell)));
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) has_ray.push_back(hasRay(camera, column, row));
    }
  }

  [[nodiscard]] std::size_t cellOf(const Eigen::Vector2d& pixel) const {
    const auto at = [](double c, int length, int count) {
      return static_cast<int>(std::clamp(std::floor((c + 0.5) / length * count), 0.0, count - 1.0));
    };
    return index(at(pixel.x(), size.width, columns), at(pixel.y(), size.height, rows));
  }
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  [[nodiscard]] Eigen::Vector2d pixelAt(double column, double row) const {
    return {column / columns * size.width - 0.5, row / rows * size.height - 0.5};
  }
  [[nodiscard]] bool isBorder(int column, int row) const {
    return column == 0 || row == 0 || column == columns - 1 || row == rows - 1;
  }

  ImageSize size;
  int columns = 0;
  int rows = 0;
  std::vector<bool> has_ray;

 private:
  [[nodiscard]] bool hasRay(const AnyCamera& camera, int column, int row) const {
    constexpr std::array<std::pair<double, double>, 5> kPlaces = {
        {{0.5, 0.5}, {0, 0}, {1, 0}, {0, 1}, {1, 1}}};
    return std::any_of(kPlaces.begin(), kPlaces.end(), [&](const auto& place) {
      return camera.unproject(pixelAt(column + place.first, row + place.second)).has_value();
    });
  }
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

void measureCells(const CellGrid& grid, CoverageReport& report) {
  Share all;
  Share border;
  std::array<Share, 9> regions;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const int count = report.num_corners[grid.index(column, row)];
      if (count < 0) continue;
      all.add(count > 0);
      if (grid.isBorder(column, row)) border.add(count > 0);
      const bool is_in_corner =
          (column == 0 || column == grid.columns - 1) && (row == 0 || row == grid.rows - 1);
      if (is_in_corner && count > 0) ++report.num_image_corners;
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

void countTilt(const BoardTilt& tilt, CoverageReport& report) {
  if (tilt.total() > kTiltedRad) ++report.num_tilted;
  if (tilt.total() > kSteepRad) ++report.num_steep;
  if (tilt.right_rad > kTiltedRad) ++report.tilts.right;
  if (tilt.right_rad < -kTiltedRad) ++report.tilts.left;
  if (tilt.lower_rad > kTiltedRad) ++report.tilts.lower;
  if (tilt.lower_rad < -kTiltedRad) ++report.tilts.upper;
}

// Names as a list for people: "the upper left corner, the left border and the centre".
std::string regionNames(const std::vector<ImageRegion>& regions) {
  std::string text;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if (i > 0) text += i + 1 == regions.size() ? " and " : ", ";
    text += "the " + regionName(regions[i]);
  }
  return text;
}

std::string sidesWithoutTilt(const TiltCounts& tilts) {
  std::vector<const char*> sides;
  if (tilts.left == 0) sides.push_back("left");
  if (tilts.right == 0) sides.push_back("right");
  if (tilts.upper == 0) sides.push_back("upper");
  if (tilts.lower == 0) sides.push_back("lower");
  return fmt::format("{}", fmt::join(sides, ", "));
}

}  // namespace

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

std::vector<std::vector<Eigen::Vector2d>> usedCorners(const Calibration& calibration,
                                                      std::span<const View> views) {
  std::set<std::pair<std::size_t, int>> left_out;
  for (const Outlier& outlier : calibration.dropped.outliers)
    left_out.emplace(outlier.source, outlier.corner_id);
  std::vector<std::vector<Eigen::Vector2d>> used;
  for (const FitView& view : calibration.fit.views) {
    expect(view.source < views.size() && views[view.source].image == view.image,
           "the views are those of the calibration");
    used.emplace_back();
    for (const Corner& corner : views[view.source].corners) {
      if (!left_out.contains({view.source, corner.id})) used.back().push_back(corner.pixel);
    }
  }
  return used;
}

CoverageReport coverageOf(const Calibration& calibration, const Checkerboard& board,
                          std::span<const View> views) {
  const AnyCamera camera = calibration.camera();
  const Fit& fit = calibration.fit;
  const CellGrid grid(camera, calibration.imageSize());
  CoverageReport report;
  report.columns = grid.columns;
  report.rows = grid.rows;
  report.num_corners.assign(grid.has_ray.size(), 0);
  const auto corners = usedCorners(calibration, views);
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& pixel : corners[v]) {
      ++report.num_corners[grid.cellOf(pixel)];
      box.extend(pixel);
    }
    const Eigen::Vector2d span = box.isEmpty() ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(box.sizes());
    report.views.push_back({.image = fit.views[v].image,
                            .sighting = sightBoard(camera, board, cameraFromBoard(fit, fit.views[v])),
                            .fill = std::max(span.x() / grid.size.width, span.y() / grid.size.height)});
    countTilt(report.views.back().sighting.tilt, report);
  }
  for (std::size_t i = 0; i < grid.has_ray.size(); ++i) {
    if (!grid.has_ray[i] && report.num_corners[i] == 0) report.num_corners[i] = -1;
  }
  measureCells(grid, report);
  if (report.views.empty()) return report;
  const auto [nearest, farthest] = std::minmax_element(
      report.views.begin(), report.views.end(),
      [](const auto& a, const auto& b) { return a.sighting.distance_m < b.sighting.distance_m; });
  report.nearest_m = nearest->sighting.distance_m;
  report.farthest_m = farthest->sighting.distance_m;
  const auto [smallest, largest] = std::minmax_element(
      report.views.begin(), report.views.end(), [](const auto& a, const auto& b) { return a.fill < b.fill; });
  report.smallest_fill = smallest->fill;
  report.largest_fill = largest->fill;
  return report;
}

std::string coverageText(const CoverageReport& report) {
  std::string text = fmt::format(
      "board corners in {:.0f} % of the image and in {} of the 4 image corners; {} of {} views tilted by "
      "more than 15 degrees, {} by more than 30; distances {:.3g} to {:.3g} m\n",
      100 * report.share, report.num_image_corners, report.num_tilted, report.views.size(), report.num_steep,
      report.nearest_m, report.farthest_m);
  if (!report.empty_regions.empty())
    text += "almost no board corners in " + regionNames(report.empty_regions) + " of the image\n";
  if (const std::string sides = sidesWithoutTilt(report.tilts); !sides.empty())
    text += "no view has this side of the board turned towards the camera by more than 15 degrees: " + sides +
            "\n";
  return text;
}

}  // namespace alidade
