// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/corner_task.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

#include "alidade/detect/corner/grey_at.h"

namespace alidade {
namespace {

// The squares around a corner; those with the colour of the one between step_u and step_v come first.
constexpr std::array<std::array<double, 2>, 4> kSquares = {{{1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};

// Grey levels of the four squares, at the share `share` of both steps.
std::array<std::optional<double>, 4> greyOfSquares(const CornerTask& task, const Eigen::Vector2d& corner,
                                                   double share) {
  constexpr double kClearOfMarkers = 0.6;
  share = std::min(share, kClearOfMarkers * task.guess.clear_share);
  std::array<std::optional<double>, 4> grey;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [u, v] = kSquares[i];
    const double share_u = u * task.shareOnSide(u > 0 ? 0 : 2, share);
    const double share_v = v * task.shareOnSide(v > 0 ? 1 : 3, share);
    grey[i] = greyAt(task.image, corner + share_u * task.guess.step_u + share_v * task.guess.step_v);
  }
  return grey;
}

// Sides on which the squares are cut: the margin beyond them is as bright as the bright squares, whereas
// complete squares still alternate there.
std::array<bool, 4> cutSides(const CornerTask& task) {
  constexpr double kNear = 0.17;    // less than a quarter by the possible error of the guess
  constexpr double kBeyond = 0.45;  // squares of at least half the size have room for the usual windows
  constexpr double kAlike = 0.3;    // share of the contrast
  const auto near = greyOfSquares(task, task.guess.pixel, kNear);
  const auto beyond = greyOfSquares(task, task.guess.pixel, kBeyond);
  if (!std::ranges::all_of(near, [](const auto& level) { return level.has_value(); })) return {};
  const double first = 0.5 * (*near[0] + *near[1]);
  const double second = 0.5 * (*near[2] + *near[3]);
  const double least = kAlike * std::abs(first - second);
  const auto alike = [&](double a, double b) { return std::abs(a - b) < least; };
  if (!alike(*near[0], *near[1]) || !alike(*near[2], *near[3])) return {};
  std::array<bool, 4> is_cut = task.guess.is_outermost;
  for (std::size_t i = 0; i < 4; ++i) {
    if (beyond[i] && alike(*beyond[i], std::max(first, second))) continue;
    is_cut[kSquares[i][0] > 0 ? 0 : 2] = is_cut[kSquares[i][1] > 0 ? 1 : 3] = false;
  }
  return is_cut;
}

// Tests if places, relative to the origin, are in the window.
class WindowTest {
 public:
  WindowTest(const EdgeWindow& window, const Eigen::Vector2i& origin) {
    Eigen::Matrix2d steps;
    steps << window.step_u, window.step_v;
    shares_ = steps.inverse();
    shares_.row(0) /= window.reach_u;
    shares_.row(1) /= window.reach_v;
    center_ = shares_ * (window.center - origin.cast<double>());
  }

  [[nodiscard]] bool contains(double x, double y) const {
    return std::abs(shares_(0, 0) * x + shares_(0, 1) * y - center_.x()) <= 1 &&
           std::abs(shares_(1, 0) * x + shares_(1, 1) * y - center_.y()) <= 1;
  }

 private:
  Eigen::Matrix2d shares_;
  Eigen::Vector2d center_;
};

// Pixels of the window's bounding box within the image, relative to the origin; empty if last < first.
struct PixelRange {
  int first = 0;
  int last = -1;
};

struct PixelBox {
  PixelRange x;
  PixelRange y;
};

PixelBox boxOf(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin) {
  const Eigen::Vector2d half =
      window.reach_u * window.step_u.cwiseAbs() + window.reach_v * window.step_v.cwiseAbs();
  const Eigen::Vector2d low = window.center - half;
  const Eigen::Vector2d high = window.center + half;
  const auto rangeOf = [](double from, double to, int size, int at) {
    return PixelRange{.first = static_cast<int>(std::ceil(std::clamp(from, 0.0, size + 1.0))) - at,
                      .last = static_cast<int>(std::floor(std::clamp(to, -1.0, size - 1.0))) - at};
  };
  return {.x = rangeOf(low.x(), high.x(), image.size.width, origin.x()),
          .y = rangeOf(low.y(), high.y(), image.size.height, origin.y())};
}

struct Line {
  Line(const EdgeModel& model, std::size_t line, double blur_reach, double most_px)
      : corner(model.corner()),
        direction(model.direction(line)),
        normal(model.normal(line)),
        curvature(model[EdgeModel::kCurvature1 + line]),
        half_width(std::min(blur_reach * model[EdgeModel::kBlur1 + line] + 0.5, most_px)) {}

  [[nodiscard]] bool isNear(double x, double y) const {
    const double dx = x - corner.x();
    const double dy = y - corner.y();
    const double u = dx * direction.x() + dy * direction.y();
    const double v = dx * normal.x() + dy * normal.y();
    return std::abs(v - 0.5 * curvature * u * u) <= half_width;
  }

  Eigen::Vector2d corner;
  Eigen::Vector2d direction;
  Eigen::Vector2d normal;
  double curvature;
  double half_width;
};

}  // namespace

void gatherLattice(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin,
                   int stride, EdgePixels& pixels) {
  pixels.clear();
  const WindowTest test(window, origin);
  const PixelBox box = boxOf(image, window, origin);
  // Rows start at different columns; otherwise an edge along the columns would lie between the same two
  // samples in all rows.
  const int shift = std::max(1, static_cast<int>(std::lround(0.38 * stride)));
  int start = 0;
  for (int y = box.y.first; y <= box.y.last; y += stride) {
    for (int x = box.x.first + start; x <= box.x.last; x += stride) {
      if (test.contains(x, y)) {
        pixels.push(static_cast<float>(x), static_cast<float>(y), image.at(x + origin.x(), y + origin.y()));
      }
    }
    start = (start + shift) % stride;
  }
}

void gatherBands(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin,
                 const EdgeModel& model, double blur_reach, const std::array<double, 2>& most_px,
                 EdgePixels& pixels) {
  pixels.clear();
  const WindowTest test(window, origin);
  const PixelBox box = boxOf(image, window, origin);
  const std::array<Line, 2> lines = {Line(model, 0, blur_reach, most_px[0]),
                                     Line(model, 1, blur_reach, most_px[1])};
  for (std::size_t i = 0; i < 2; ++i) {
    const Line& line = lines[i];
    // Steps along the image axis that is closer to the line, and takes the pixels around the line on the
    // other axis.
    const int along = std::abs(line.direction.x()) >= std::abs(line.direction.y()) ? 0 : 1;
    const int across = 1 - along;
    const PixelRange& outer = along == 0 ? box.x : box.y;
    const PixelRange& inner = along == 0 ? box.y : box.x;
    const double slope = line.direction[across] / line.direction[along];
    // One more pixel for the curvature, which is only approximate here: isNear() decides.
    const double half = line.half_width / std::abs(line.direction[along]) + 1;
    for (int p = outer.first; p <= outer.last; ++p) {
      const double off = p - line.corner[along];
      const double u = off / line.direction[along];
      const double middle =
          line.corner[across] + slope * off + 0.5 * line.curvature * u * u / line.normal[across];
      if (!(std::abs(middle) < 1e6)) continue;
      const int first = std::max(inner.first, static_cast<int>(std::ceil(middle - half)));
      const int last = std::min(inner.last, static_cast<int>(std::floor(middle + half)));
      for (int q = first; q <= last; ++q) {
        const int x = along == 0 ? p : q;
        const int y = along == 0 ? q : p;
        if (!line.isNear(x, y) || !test.contains(x, y) || (i == 1 && lines[0].isNear(x, y))) continue;
        pixels.push(static_cast<float>(x), static_cast<float>(y), image.at(x + origin.x(), y + origin.y()));
      }
    }
  }
}

std::optional<CornerTask> makeCornerTask(const GrayImage& image, const CornerGuess& guess) {
  constexpr double kMinSpacingPx = 4;
  constexpr double kMaxStepPx = 1e5;
  if (image.empty() || !guess.pixel.allFinite() || !guess.step_u.allFinite() || !guess.step_v.allFinite())
    return std::nullopt;
  const double length_u = guess.step_u.norm();
  const double length_v = guess.step_v.norm();
  const double spacing = std::min(length_u, length_v);
  if (!(spacing >= kMinSpacingPx && std::max(length_u, length_v) <= kMaxStepPx)) return std::nullopt;
  const double sine = std::abs(crossProduct(guess.step_u, guess.step_v)) / (length_u * length_v);
  if (!(sine >= std::sin(kMinCrossingDeg * std::numbers::pi / 180))) return std::nullopt;
  if (!(guess.pixel.x() > -spacing && guess.pixel.x() < image.size.width + spacing &&
        guess.pixel.y() > -spacing && guess.pixel.y() < image.size.height + spacing))
    return std::nullopt;
  CornerTask task{.image = image,
                  .guess = guess,
                  .origin = {static_cast<int>(std::lround(guess.pixel.x())),
                             static_cast<int>(std::lround(guess.pixel.y()))},
                  .spacing = spacing,
                  .crossing_sine = sine};
  task.is_cut = cutSides(task);
  return task;
}

std::optional<double> CornerTask::contrastOfSquares(const Eigen::Vector2d& corner) const {
  constexpr double kShare = 0.4;
  const auto grey = greyOfSquares(*this, corner, kShare);
  if (!std::all_of(grey.begin(), grey.end(), [](const auto& level) { return level.has_value(); }))
    return std::nullopt;
  const double contrast = 0.5 * (*grey[2] + *grey[3] - *grey[0] - *grey[1]);
  const double gap = contrast > 0 ? std::min(*grey[2], *grey[3]) - std::max(*grey[0], *grey[1])
                                  : std::min(*grey[0], *grey[1]) - std::max(*grey[2], *grey[3]);
  constexpr double kLeastGap = 0.3;
  if (!(gap >= kLeastGap * std::abs(contrast))) return std::nullopt;
  return contrast;
}

bool CornerTask::hasColoursOf(const CornerFit& fit) const {
  constexpr double kShare = 0.35;
  constexpr double kLeastGap = 0.25;  // share of the contrast
  const auto grey = greyOfSquares(*this, fit.pixel, kShare);
  double darkest_bright = std::numeric_limits<double>::infinity();
  double brightest_dark = -darkest_bright;
  for (std::size_t i = 0; i < 4; ++i) {
    if (!grey[i]) continue;
    if ((i < 2) == (fit.contrast > 0)) {
      brightest_dark = std::max(brightest_dark, *grey[i]);
    } else {
      darkest_bright = std::min(darkest_bright, *grey[i]);
    }
  }
  return darkest_bright - brightest_dark > kLeastGap * std::abs(fit.contrast);
}

}  // namespace alidade
