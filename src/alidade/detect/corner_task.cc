// SPDX-License-Identifier: MIT
#include "alidade/detect/corner_task.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace alidade {

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

}  // namespace alidade
