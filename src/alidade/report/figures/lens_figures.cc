// SPDX-License-Identifier: MIT
#include "alidade/report/figures/camera_figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/camera/correction_field.h"
#include "alidade/camera/pinhole.h"
#include "alidade/core/degrees.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The largest angle from the axis over these pixels, radians.
template <class Pixels>
double largestAngle(const AnyCamera& camera, const Pixels& pixels) {
  double angle = 0;
  for (const Vector2d& pixel : pixels) {
    const auto ray = camera.unproject(pixel);
    if (ray) angle = std::max(angle, std::atan2(std::hypot(ray->x(), ray->y()), ray->z()));
  }
  return angle;
}

std::vector<Vector2d> borderPixels(const ImageSize& size) {
  constexpr int kSteps = 32;
  std::vector<Vector2d> pixels;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = (size.width - 1.0) * i / kSteps;
    const double y = (size.height - 1.0) * i / kSteps;
    pixels.insert(pixels.end(), {{x, 0}, {x, size.height - 1.0}, {0, y}, {size.width - 1.0, y}});
  }
  return pixels;
}

Vector2d principalPoint(const AnyCamera& camera) {
  return {camera.parameter("cx"), camera.parameter("cy")};
}

std::optional<Vector2d> pixelOf(const AnyCamera& camera, const Vector3d& ray) {
  const Projection seen = camera.project(ray);
  return seen.ok() ? std::optional(seen.pixel) : std::nullopt;
}

// The pieces inside the image of a line through the pixels 0 to `num_steps`.
template <class PixelAt>
std::string shownLine(const FigureCanvas& canvas, int num_steps, const PixelAt& pixel_at) {
  const Eigen::AlignedBox2d shown(canvas.area().low, canvas.area().high);
  std::string d;
  std::vector<Vector2d> piece;
  for (int i = 0; i <= num_steps; ++i) {
    const std::optional<Vector2d> pixel = pixel_at(i);
    const bool is_shown = pixel && shown.contains(*pixel);
    if (is_shown) piece.push_back(canvas.at(*pixel));
    if (is_shown && i < num_steps) continue;
    if (piece.size() > 1) d += pathThrough(piece);
    piece.clear();
  }
  return d;
}

// Planes through the camera's x or y axis: each meets the scene in a straight line, and together they form a
// grid of squares on a wall in front of the camera.
std::string gridPath(const AnyCamera& camera, const FigureCanvas& canvas, double step_rad, double end_rad) {
  constexpr int kSteps = 180;
  std::string d;
  const int count = static_cast<int>(end_rad / step_rad);
  for (int k = -count; k <= count; ++k) {
    const double a = k * step_rad;
    for (const bool is_upright : {true, false}) {
      d += shownLine(canvas, kSteps, [&](int i) {
        const double b = std::numbers::pi * (static_cast<double>(i) / kSteps - 0.5);
        const Vector2d side(std::sin(a) * std::cos(b), std::sin(b));
        return pixelOf(camera,
                       {side(is_upright ? 0 : 1), side(is_upright ? 1 : 0), std::cos(a) * std::cos(b)});
      });
    }
  }
  return d;
}

// Circles of equal angle from the axis, every `step_rad`, inside the image.
template <class PixelAt>
std::string ringsPath(const FigureCanvas& canvas, double step_rad, double end_rad, const PixelAt& pixel_at) {
  constexpr int kSteps = 120;
  std::string d;
  for (int k = 1; k * step_rad <= end_rad + 1e-9; ++k)
    d += shownLine(canvas, kSteps,
                   [&](int i) { return pixel_at(k * step_rad, 2 * std::numbers::pi * i / kSteps); });
  return d;
}

// The focal length on the axis, in px per radian.
double axisFocal(const AnyCamera& camera) {
  constexpr double kSmall = 1e-4;
  const Projection ahead = camera.project({0, 0, 1});
  const Projection beside = camera.project({kSmall, 0, 1});
  if (!ahead.ok() || !beside.ok()) return camera.parameter("fx");
  return (beside.pixel - ahead.pixel).norm() / kSmall;
}

// Mean distance from the principal point at this angle, over directions that have a pixel; NaN if none has.
double radiusAt(const AnyCamera& camera, double angle) {
  constexpr int kDirections = 8;
  double sum = 0;
  int count = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double phi = 2 * std::numbers::pi * i / kDirections;
    const Projection seen =
        camera.project({std::sin(angle) * std::cos(phi), std::sin(angle) * std::sin(phi), std::cos(angle)});
    if (!seen.ok()) continue;
    sum += (seen.pixel - principalPoint(camera)).norm();
    ++count;
  }
  return count == 0 ? std::numeric_limits<double>::quiet_NaN() : sum / count;
}

constexpr int kRadialSteps = 120;

// Angles (degrees) up to an end and their distances from the principal point, where defined.
std::vector<Vector2d> radialCurve(const AnyCamera& camera, double end_rad) {
  std::vector<Vector2d> curve;
  for (int i = 0; i <= kRadialSteps; ++i) {
    const double angle = end_rad * i / kRadialSteps;
    const double radius = radiusAt(camera, angle);
    if (std::isfinite(radius)) curve.emplace_back(angle / kRadPerDeg, radius);
  }
  return curve;
}

std::string radialReading(bool are_boards_seen, bool have_rays) {
  std::string reading = "The curve shows how far from the principal point a direction appears.";
  if (are_boards_seen) {
    reading += " Beyond the line for the boards it is extrapolated";
    reading += have_rays ? ", and it must rise up to the image corner." : ".";
  } else if (have_rays) {
    reading += " It must rise up to the image corner.";
  }
  if (!have_rays)
    reading +=
        " It ends before the image corner, which this model maps to no direction: use only what lies within.";
  return reading;
}

// A vertical line in a chart at an angle, with a legend entry.
void addAngleLimit(FigureCanvas& canvas, double angle_rad, const std::string& words, const char* kind,
                   Legend& legend) {
  const PlotArea& area = canvas.area();
  const double x = angle_rad / kRadPerDeg;
  if (!(x > area.low.x() && x <= area.high.x())) return;
  canvas.addLine(area.at(x, area.low.y()), area.at(x, area.high.y()),
                 fmt::format("class=\"limit {}\" data-angle=\"{:.6g}\"", kind, x));
  legend.emplace_back(fmt::format("line limit {}", kind), fmt::format("{} {:.1f}°", words, x));
}

// The largest distance of these pixels from the principal point.
double largestRadius(const AnyCamera& camera, const std::vector<Vector2d>& pixels) {
  double radius = 0;
  for (const Vector2d& pixel : pixels) radius = std::max(radius, (pixel - principalPoint(camera)).norm());
  return radius;
}

// Largest angle at which boards were seen; 0 without views.
double coveredAngle(const ReportData& data) {
  double angle = 0;
  for (const ReportedView& view : data.views) {
    std::vector<Vector2d> pixels;
    for (const CornerError& corner : view.corners) pixels.push_back(corner.pixel);
    angle = std::max(angle, largestAngle(data.camera, pixels));
  }
  return angle;
}

// Rings of equal angle; a grid of straight lines would converge in the image of a wide lens.
Legend addRings(const ReportData& data, double end_rad, FigureCanvas& canvas) {
  constexpr double kStep = 10 * kRadPerDeg;
  const Vector2d centre = principalPoint(data.camera);
  const double focal = axisFocal(data.camera);
  const double aspect = data.camera.parameter("fy") / data.camera.parameter("fx");
  const auto direction = [](double phi) { return Vector2d(std::cos(phi), std::sin(phi)); };
  canvas.addPath(ringsPath(canvas, kStep, end_rad,
                           [&](double angle, double phi) -> Vector2d {
                             return centre + focal * angle * direction(phi).cwiseProduct(Vector2d(1, aspect));
                           }),
                 "straight");
  const auto seenAt = [&](double angle, double phi) {
    const Vector2d side = std::sin(angle) * direction(phi);
    return pixelOf(data.camera, {side.x(), side.y(), std::cos(angle)});
  };
  canvas.addPath(ringsPath(canvas, kStep, end_rad, seenAt), "bent");
  const Eigen::AlignedBox2d shown(canvas.area().low, canvas.area().high);
  for (int k = 3; k * kStep <= end_rad; k += 3) {
    const auto pixel = seenAt(k * kStep, -0.25 * std::numbers::pi);
    if (pixel && shown.contains(*pixel))
      canvas.addText(canvas.at(*pixel) + Vector2d(0, 4), fmt::format("{}°", 10 * k), "middle", "tick halo");
  }
  return {{"line bent", "every 10° from the axis"}, {"line straight", "equidistant fisheye"}};
}

Legend addStraightLines(const ReportData& data, double end_rad, double focal, FigureCanvas& canvas) {
  const double step = kRadPerDeg * (end_rad > 0.9 ? 10 : end_rad > 0.35 ? 5 : end_rad > 0.15 ? 2 : 1);
  const AnyCamera pinhole = AnyCamera::make(
      Pinhole::kId,
      std::vector<double>{focal, focal * data.camera.parameter("fy") / data.camera.parameter("fx"),
                          principalPoint(data.camera).x(), principalPoint(data.camera).y()});
  canvas.addPath(gridPath(pinhole, canvas, step, end_rad), "straight");
  canvas.addPath(gridPath(data.camera, canvas, step, end_rad), "bent");
  return {{"line bent", fmt::format("straight lines every {:.0f}°", step / kRadPerDeg)},
          {"line straight", "without distortion"}};
}

// The images of straight lines of the scene, over those of a pinhole camera.
Figure distortionGridFigure(const ReportData& data) {
  constexpr double kWide = 62 * kRadPerDeg;
  const double end = largestAngle(data.camera, borderPixels(data.size));
  const double focal = axisFocal(data.camera);
  const bool is_wide = end > kWide || !(focal > 0);
  FigureCanvas canvas(data.size, "paper");
  Legend legend = is_wide ? addRings(data, end, canvas) : addStraightLines(data, end, focal, canvas);
  legend.emplace_back("line cross", "principal point");
  const Vector2d axis = canvas.at(principalPoint(data.camera));
  canvas.addPath(pathThrough({axis - Vector2d(6, 0), axis + Vector2d(6, 0)}) +
                     pathThrough({axis - Vector2d(0, 6), axis + Vector2d(0, 6)}),
                 "cross");
  canvas.addImageFrame();
  return canvas.drawn(
      {.id = "distortion-grid",
       .title = "Distortion",
       .reading = is_wide
                      ? "The rings show directions 10, 20, 30 degrees and so on from the optical axis; they "
                        "should be smooth, evenly changing circles up to the corners of the image."
                      : "These curves are straight lines in the scene; the more they bend, the stronger the "
                        "distortion, and they should bend smoothly up to the corners of the image.",
       .alt = fmt::format("{} {} lens{}, up to {:.0f} degrees from the axis.",
                          is_wide ? "Rings of equal angle of the" : "Straight lines of the scene as the",
                          data.camera.modelId(), is_wide ? "" : " shows them", end / kRadPerDeg)},
      legend);
}

// Distance from the principal point over the angle from the optical axis, with the end of the model's domain
// and that of the range covered by boards.
Figure radialFigure(const ReportData& data) {
  // Dark corners of a fisheye have no ray, so their angle is undefined.
  const std::vector<Vector2d> corners =
      cornersOf({Vector2d(0, 0), Vector2d(data.size.width - 1.0, data.size.height - 1.0)});
  const bool have_rays = std::ranges::all_of(
      corners, [&](const Vector2d& corner) { return data.camera.unproject(corner).has_value(); });
  const double image_end = largestAngle(data.camera, have_rays ? corners : borderPixels(data.size));
  const double corner_px = largestRadius(data.camera, corners);
  const double covered_end = coveredAngle(data);
  const double domain_end = data.camera.cone().max_angle_rad;
  const double end = std::min(std::numbers::pi, 1.08 * std::max(image_end, covered_end));
  const std::vector<Vector2d> lens = radialCurve(data.camera, std::min(end, domain_end));
  double most = 0;
  for (const Vector2d& point : lens) most = std::max(most, point.y());
  most = std::clamp(most, 1.0, Vector2d(data.size.width, data.size.height).norm());
  if (!have_rays) most = std::max(most, corner_px);
  FigureCanvas canvas(Vector2d(0, 0), Vector2d(end > 0 ? end / kRadPerDeg : 90, 1.1 * most));
  const PlotArea& area = canvas.area();
  canvas.addAxes("angle from the optical axis, degrees", "distance from the principal point, px");
  const double focal = axisFocal(data.camera);
  std::vector<Vector2d> pinhole;
  std::vector<Vector2d> even;
  for (int i = 0; i <= kRadialSteps; ++i) {
    const double angle = end * i / kRadialSteps;
    if (angle < 1.5 && focal * std::tan(angle) <= area.high.y())
      pinhole.push_back(area.at(angle / kRadPerDeg, focal * std::tan(angle)));
    if (focal * angle <= area.high.y()) even.push_back(area.at(angle / kRadPerDeg, focal * angle));
  }
  std::vector<Vector2d> curve;
  for (const Vector2d& point : lens)
    if (point.y() <= area.high.y()) curve.push_back(area.at(point));
  canvas.addPath(pathThrough(pinhole), "straight");
  const bool is_wide = image_end > 0.9;
  if (is_wide) canvas.addPath(pathThrough(even), "straight dotted");
  canvas.addPath(pathThrough(curve), "curve");
  Legend legend = {{"line curve", "this lens"}, {"line straight", "no distortion"}};
  if (is_wide) legend.emplace_back("line straight dotted", "equidistant fisheye");
  addAngleLimit(canvas, covered_end, "boards seen up to", "covered", legend);
  addAngleLimit(canvas, image_end, have_rays ? "image corner at" : "last border pixel with a ray at", "image",
                legend);
  addAngleLimit(canvas, domain_end, "the model ends at", "domain", legend);
  if (!have_rays && corner_px <= area.high.y()) {
    canvas.addLine(area.at(area.low.x(), corner_px), area.at(area.high.x(), corner_px),
                   fmt::format("class=\"limit blind-corner\" data-radius=\"{:.6g}\"", corner_px));
    legend.emplace_back("line limit blind-corner", fmt::format("image corner, {:.0f} px: no ray", corner_px));
  }
  std::string reading = radialReading(covered_end > 0, have_rays);
  if (domain_end >= end)
    reading += fmt::format(" The model ends at {:.1f}°, beyond this figure.", domain_end / kRadPerDeg);
  const std::string alt = fmt::format(
      "Radius over angle: {}{} {:.1f} degrees, and the model goes up to {:.1f} degrees from the axis.",
      covered_end > 0 ? fmt::format("boards were seen up to {:.1f} degrees, ", covered_end / kRadPerDeg) : "",
      have_rays ? "the image corner is at"
                : "the image corners have no ray, the last border pixel with one is at",
      image_end / kRadPerDeg, domain_end / kRadPerDeg);
  return canvas.drawn({.id = "radial", .title = "Radial curve", .reading = reading, .alt = alt}, legend);
}

// The start of a ray on the axis over its angle, up to the range covered by boards. @pre the entrance pupil
// moves
Figure pupilFigure(const ReportData& data) {
  const EntrancePupil& pupil = data.camera.pupil();
  const double covered = coveredAngle(data);
  const double end = covered > 0 ? covered : std::min(data.camera.cone().max_angle_rad, 1.5);
  const auto millimetres = [&](double angle) { return 1e3 * pupil.at(angle); };
  double low = 0;
  double high = 0;
  for (int i = 0; i <= kRadialSteps; ++i) {
    low = std::min(low, millimetres(end * i / kRadialSteps));
    high = std::max(high, millimetres(end * i / kRadialSteps));
  }
  const double margin = 0.1 * (high - low);
  FigureCanvas canvas(Vector2d(0, low - margin), Vector2d(end / kRadPerDeg, high + margin));
  canvas.addAxes("angle from the optical axis, degrees", "start of the ray on the axis, mm");
  std::vector<Vector2d> curve;
  for (int i = 0; i <= kRadialSteps; ++i) {
    const double angle = end * i / kRadialSteps;
    curve.push_back(canvas.area().at(angle / kRadPerDeg, millimetres(angle)));
  }
  canvas.addPath(pathThrough(curve), "curve");
  const std::string where = fmt::format("{:.3g} mm at {:.0f} degrees", millimetres(end), end / kRadPerDeg);
  return canvas.drawn(
      {.id = "pupil",
       .title = "Entrance pupil",
       .reading = "Where on the axis a ray starts, by its angle; above 0: towards the scene. Near points see "
                  "this, and far ones do not.",
       .alt = "The entrance pupil moves along the axis: by " + where + "."},
      {{"line curve", "start of the ray"}});
}

// The correction field as arrows over the image. @pre the camera has one
Figure correctionFigure(const ReportData& data) {
  const CorrectionField& field = *data.camera.correction();
  constexpr int kAcross = 26;  // arrows
  const double step = static_cast<double>(std::max(data.size.width, data.size.height)) / kAcross;
  std::vector<std::pair<Vector2d, Vector2d>> moves;
  double longest = 0;
  double squares = 0;
  for (double v = 0.5 * step; v < data.size.height; v += step) {
    for (double u = 0.5 * step; u < data.size.width; u += step) {
      const Vector2d move = field.at({u, v});
      moves.emplace_back(Vector2d(u, v), move);
      longest = std::max(longest, move.norm());
      squares += move.squaredNorm();
    }
  }
  FigureCanvas canvas(data.size, "paper");
  const double scale = longest > 0 ? 1.6 * step * canvas.area().scale() / longest : 0.0;
  std::string d;
  for (const auto& [from, move] : moves) d += arrowPath(canvas.at(from), scale * move);
  canvas.addMeanArrows(d);
  canvas.addImageFrame();
  const double rms_px = std::sqrt(squares / static_cast<double>(moves.size()));
  return canvas.drawn(
      {.id = "correction",
       .title = "Correction field",
       .reading =
           "How far this lens moves pixels from where its model alone puts them. Arrows are enlarged; those of "
           "a real lens change smoothly, and are short where no board was seen.",
       .alt = fmt::format("The correction field moves pixels by {:.2g} px (RMS over the image).", rms_px)},
      {{fmt::format("arrow {:.1f} mean", 0.5 * scale * longest), fmt::format("{:.2g} px", 0.5 * longest)}});
}

}  // namespace

Figure correlationFigure(const ReportData& data) {
  const Eigen::MatrixXd& covariance = *data.covariance;
  const auto names = data.camera.parameterNames();
  std::vector<Eigen::Index> estimated;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i)
    if (covariance(i, i) > 0) estimated.push_back(i);
  const auto count = static_cast<double>(estimated.size());
  constexpr double kLeft = 44;
  constexpr double kTop = 8;
  const double cell = count > 0 ? std::min(38.0, 380 / count) : 38;
  FigureCanvas canvas(kTop + count * cell + 24);
  double strongest = 0;
  std::string pair = "none";
  for (std::size_t r = 0; r < estimated.size(); ++r) {
    const auto name = [&](std::size_t i) { return names[static_cast<std::size_t>(estimated[i])]; };
    const double y = kTop + static_cast<double>(r) * cell;
    canvas.addText({kLeft - 6, y + 0.5 * cell + 4}, name(r), "end", "tick");
    canvas.addText({kLeft + (static_cast<double>(r) + 0.5) * cell, kTop + count * cell + 15}, name(r),
                   "middle", "tick");
    for (std::size_t c = 0; c <= r; ++c) {
      const double value =
          covariance(estimated[r], estimated[c]) /
          std::sqrt(covariance(estimated[r], estimated[r]) * covariance(estimated[c], estimated[c]));
      const Vector2d low(kLeft + static_cast<double>(c) * cell, y);
      canvas.addRect(low, low + Vector2d(cell, cell), "cell");
      canvas.addRect(low + Vector2d(1, 1), low + Vector2d(cell - 1, cell - 1),
                     fmt::format("class=\"{}\" fill-opacity=\"{:.2f}\"",
                                 c == r      ? "empty"
                                 : value < 0 ? "cold"
                                             : "warm",
                                 c == r ? 1 : 0.6 * std::abs(value)));
      if (cell > 24 && c != r)
        canvas.addText(low + Vector2d(0.5 * cell, 0.5 * cell + 4), fmt::format("{:.2f}", value), "middle");
      if (c == r || !(std::abs(value) > std::abs(strongest))) continue;
      strongest = value;
      pair = fmt::format("{} and {}", name(c), name(r));
    }
  }
  return canvas.drawn(
      {.id = "correlations",
       .title = "Correlations of the parameters",
       .reading = "Strong colours are pairs whose errors go together: near 1 or -1 the photographs do not "
                  "separate the two. fx with fy, and k1, k2, k3 with each other, are always strongly "
                  "related. Look at cx or cy with p1 or p2: if strong, tilt the board more.",
       .alt = fmt::format("Correlations of {} parameters; the strongest is {:.3f}, between {}.",
                          estimated.size(), strongest, pair)});
}

std::vector<Figure> lensFigures(const ReportData& data) {
  std::vector<Figure> figures = {distortionGridFigure(data), radialFigure(data)};
  if (!data.camera.pupil().isFixed()) figures.push_back(pupilFigure(data));
  if (data.camera.correction() != nullptr) figures.push_back(correctionFigure(data));
  return figures;
}

}  // namespace alidade
