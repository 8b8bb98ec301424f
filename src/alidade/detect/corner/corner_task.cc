// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/corner_task.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace alidade {
namespace {

// Grey level between pixels, by the four around; nothing outside of the image.
std::optional<double> greyAt(const GrayImage& image, const Eigen::Vector2d& pixel) {
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= image.size.width - 1 &&
        pixel.y() <= image.size.height - 1))
    return std::nullopt;
  const int x = std::min(static_cast<int>(pixel.x()), std::max(0, image.size.width - 2));
  const int y = std::min(static_cast<int>(pixel.y()), std::max(0, image.size.height - 2));
  const int next_x = std::min(x + 1, image.size.width - 1);
  const int next_y = std::min(y + 1, image.size.height - 1);
  const double fx = pixel.x() - x;
  const double fy = pixel.y() - y;
  return (1 - fy) * ((1 - fx) * image.at(x, y) + fx * image.at(next_x, y)) +
         fy * ((1 - fx) * image.at(x, next_y) + fx * image.at(next_x, next_y));
}

// Of the four squares, at `share` of the way along both steps; those that look like the one between step_u
// and step_v come first.
std::array<std::optional<double>, 4> greyOfSquares(const CornerTask& task, const Eigen::Vector2d& corner,
                                                   double share) {
  constexpr std::array<std::array<double, 2>, 4> kSquares = {{{1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};
  std::array<std::optional<double>, 4> grey;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [u, v] = kSquares[i];
    grey[i] = greyAt(task.image, corner + share * (u * task.guess.step_u + v * task.guess.step_v));
  }
  return grey;
}

}  // namespace

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
  return CornerTask{.image = image,
                    .guess = guess,
                    .origin = {static_cast<int>(std::lround(guess.pixel.x())),
                               static_cast<int>(std::lround(guess.pixel.y()))},
                    .spacing = spacing,
                    .crossing_sine = sine};
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
  constexpr double kLeastGap = 0.25;  // of the contrast
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
