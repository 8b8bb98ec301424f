// SPDX-License-Identifier: MIT
#include "alidade/report/figures/undistorted_figure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

// Largest diagonal field of a plane picture; beyond it the border is stretched too much.
constexpr double kMostFieldRad = 2.1;

double seenArea(const ReportedView& view) {
  Eigen::AlignedBox2d box;
  for (const ReportedCorner& corner : view.corners) box.extend(corner.pixel);
  return view.corners.empty() ? 0 : box.volume();
}

// Output view of the picture: as much of the image as a plane shows well.
OutputView plainView(const ReportData& data) {
  const ImageSize size{
      .width = 800,
      .height = std::max(1, static_cast<int>(std::lround(800.0 * data.size.height / data.size.width)))};
  const ViewChoice all = chooseView(data.camera, data.size, {.extent = ViewExtent::kAll, .size = size});
  if (all.view.horizontalFieldRad() <= kMostFieldRad) return all.view;
  return chooseView(data.camera, data.size,
                    {.extent = ViewExtent::kFieldOfView, .horizontal_field_rad = kMostFieldRad, .size = size})
      .view;
}

struct BoardLine {
  Vector2d from;
  Vector2d to;
  double largest_px = 0;  // distance of a corner from the line
};

// The line with the least squared distances from the points. @pre two or more
BoardLine lineThrough(const std::vector<Vector2d>& points) {
  Vector2d mean(0, 0);
  for (const Vector2d& point : points) mean += point / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Vector2d& point : points) scatter += (point - mean) * (point - mean).transpose();
  const double angle = 0.5 * std::atan2(2 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
  const Vector2d along(std::cos(angle), std::sin(angle));
  const Vector2d across(-along.y(), along.x());
  double low = 0;
  double high = 0;
  BoardLine line;
  for (const Vector2d& point : points) {
    low = std::min(low, along.dot(point - mean));
    high = std::max(high, along.dot(point - mean));
    line.largest_px = std::max(line.largest_px, std::abs(across.dot(point - mean)));
  }
  const double beyond = 0.06 * (high - low);
  line.from = mean + (low - beyond) * along;
  line.to = mean + (high + beyond) * along;
  return line;
}

// Lines through the rows and columns of a view's board that show three points or more.
std::vector<BoardLine> boardLines(const ReportData& data, const ReportedView& view, const OutputView& plain) {
  const Board& target = data.boards[view.board].target;
  std::map<std::pair<bool, int>, std::vector<Vector2d>> rows;
  for (const ReportedCorner& corner : view.corners) {
    const auto ray = data.camera.unproject(corner.pixel);
    if (!ray) continue;
    const auto place = planeFromRay(ViewProjection::kRectilinear, *ray);
    if (!place) continue;
    const Vector2d pixel = plain.scale_px.cwiseProduct(*place) + plain.axis_px;
    // Rows of circles may be staggered: points of a row are then still collinear, but those of a column are
    // not.
    const Eigen::Vector3d& at = target.corner(corner.id);
    rows[{true, static_cast<int>(std::lround(1e5 * at.y()))}].push_back(pixel);
    rows[{false, static_cast<int>(std::lround(1e5 * at.x()))}].push_back(pixel);
  }
  std::vector<BoardLine> lines;
  for (const auto& [key, points] : rows)
    if (points.size() >= 3) lines.push_back(lineThrough(points));
  return lines;
}

GrayImage remapped(const ReportData& data, const GrayImage& image, const OutputView& plain) {
  const RemapTable table = makeRemapTable(data.camera, data.size, plain);
  const RasterImage raster =
      remap(table, {.size = image.size, .bytes = image.pixels}, Interpolation::kLinear);
  return {.size = raster.size, .pixels = raster.bytes};
}

}  // namespace

std::string undistortedImageName(const ReportData& data) {
  return data.views.empty() ? "" : std::ranges::max_element(data.views, {}, seenArea)->image;
}

std::optional<Figure> undistortedFigure(const ReportData& data, const ImageOfView& image_of) {
  constexpr double kMostBytes = 60e3;
  if (!image_of || data.views.empty()) return std::nullopt;
  const ReportedView& view = *std::ranges::max_element(data.views, {}, seenArea);
  const std::optional<GrayImage> image = image_of(view.image);
  if (!image || image->size != data.size) return std::nullopt;
  std::optional<OutputView> plain;
  try {
    plain = plainView(data);
  } catch (const Error&) {
    return std::nullopt;  // this camera's field does not fit a plane
  }
  const ImagePlot plot = imagePlot(plain->size);
  const PlotArea& area = plot.area;
  FigureCanvas canvas(plot.legend_top - 10);
  canvas.addRaw(fmt::format(
      "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" href=\"{}\"/>\n",
      coordinate(area.box.min().x()), coordinate(area.box.min().y()), coordinate(area.box.sizes().x()),
      coordinate(area.box.sizes().y()), pictureUri(remapped(data, *image, *plain), kMostBytes)));
  const std::vector<BoardLine> lines = boardLines(data, view, *plain);
  double largest = 0;
  std::string d;
  for (const BoardLine& line : lines) {
    d += pathThrough({area.at(line.from), area.at(line.to)});
    largest = std::max(largest, line.largest_px);
  }
  canvas.addClip("plain-clip", area);
  canvas.addPath(d, "class=\"ruler\" clip-path=\"url(#plain-clip)\"");
  canvas.addRect(area.box.min(), area.box.max(), "class=\"frame\"");
  canvas.addLegend(
      {area.box.min().x(), plot.legend_top - 12},
      {{"line ruler", fmt::format("largest distance of a corner from its line: {} px", twoDigits(largest))}});
  Figure figure{.id = "undistorted", .title = "An image without distortion"};
  figure.reading = fmt::format(
      "This is {}. The edges of the board should lie on the straight lines over their whole length; if they "
      "bow, the distortion is wrong there.",
      view.image);
  figure.alt = fmt::format(
      "{} without distortion: its corners lie up to {} px from straight lines through rows and columns of "
      "the board.",
      view.image, twoDigits(largest));
  return canvas.drawn(std::move(figure));
}

}  // namespace alidade
