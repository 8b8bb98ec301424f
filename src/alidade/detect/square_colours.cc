// SPDX-License-Identifier: MIT
#include "alidade/detect/square_colours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

}  // namespace

std::optional<double> contrastOfSquares(const GrayImage& image, const CornerGuess& guess,
                                        const Eigen::Vector2d& corner) {
  constexpr double kShare = 0.4;
  std::array<double, 4> grey{};
  std::size_t i = 0;
  for (const auto& [u, v] : std::array<std::array<double, 2>, 4>{{{1, 1}, {-1, -1}, {1, -1}, {-1, 1}}}) {
    const auto level = greyAt(image, corner + kShare * (u * guess.step_u + v * guess.step_v));
    if (!level) return std::nullopt;
    grey[i++] = *level;
  }
  const double contrast = 0.5 * (grey[2] + grey[3] - grey[0] - grey[1]);
  const double gap = contrast > 0 ? std::min(grey[2], grey[3]) - std::max(grey[0], grey[1])
                                  : std::min(grey[0], grey[1]) - std::max(grey[2], grey[3]);
  constexpr double kLeastGap = 0.3;
  if (!(gap >= kLeastGap * std::abs(contrast))) return std::nullopt;
  return contrast;
}

bool haveColoursOfFit(const GrayImage& image, const CornerGuess& guess, const CornerFit& fit) {
  constexpr double kShare = 0.35;
  constexpr double kLeastGap = 0.25;  // of the contrast
  double darkest_bright = std::numeric_limits<double>::infinity();
  double brightest_dark = -darkest_bright;
  for (const auto& [u, v] : std::array<std::array<double, 2>, 4>{{{1, 1}, {-1, -1}, {1, -1}, {-1, 1}}}) {
    const auto level = greyAt(image, fit.pixel + kShare * (u * guess.step_u + v * guess.step_v));
    if (!level) continue;
    if ((u * v > 0) == (fit.contrast > 0)) {
      brightest_dark = std::max(brightest_dark, *level);
    } else {
      darkest_bright = std::min(darkest_bright, *level);
    }
  }
  return darkest_bright - brightest_dark > kLeastGap * std::abs(fit.contrast);
}

}  // namespace alidade
