// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "alidade/core/image.h"

namespace alidade {

/// What happens to an image between the lens and the file, besides noise.
enum class Degradation {
  kNone,
  kMotionBlur,    ///< 8 px along a line that rises by 30 degrees
  kDefocus,       ///< an even disk of 4 px radius
  kGamma,         ///< grey = 255 (light / 255)^(1 / 2.2)
  kClippedWhite,  ///< 1.5 times the light, cut at 255
  kSharpened,     ///< unsharp mask: 1.5 times the difference to a blur of 1.5 px added
  kJpeg,          ///< JPEG at quality 30
};

inline constexpr Degradation kAllDegradations[] = {Degradation::kMotionBlur, Degradation::kDefocus,
                                                   Degradation::kGamma,      Degradation::kClippedWhite,
                                                   Degradation::kSharpened,  Degradation::kJpeg};

[[nodiscard]] std::string_view nameOf(Degradation degradation);

/// Degrades an image that was rendered without noise. Normal noise of standard deviation `noise` grey levels
/// joins where a sensor has it: after the optics and exposure (motion, defocus, clipping), before the tone
/// curve, sharpening and compression. Everything is symmetric about each pixel, so that no corner moves.
[[nodiscard]] GrayImage degraded(const GrayImage& image, Degradation degradation, double noise,
                                 std::uint64_t seed);

}  // namespace alidade
