// SPDX-License-Identifier: MIT
#include "alidade/record/scene.h"

#include <limits>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/record/footage_scene.h"

namespace alidade {
namespace {

constexpr double kMaxLevel = 255;

}  // namespace

namespace detail {

void checkOption(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw inputError({.where = name,
                    .found = exactText(value),
                    .expected = "a number from " + exactText(low) + " to " + exactText(high)});
}

}  // namespace detail

void RandomViewOptions::validate() const {
  constexpr double kMaxTiltDeg = 89;  // edge-on, a board has no image
  detail::checkOption("max_tilt_deg", max_tilt_deg, 0, kMaxTiltDeg);
  detail::checkOption("max_roll_deg", max_roll_deg, 0, 180);
  detail::checkOption("min_fill", min_fill, kSmallestFill, 1);
  detail::checkOption("max_fill", max_fill, min_fill, 1);
  detail::checkOption("margin_px", margin_px, 0, std::numeric_limits<double>::max());
  detail::checkOption("max_attempts", max_attempts, 1, std::numeric_limits<int>::max());
}

void RenderOptions::validate() const {
  constexpr double kMaxBlurPx = 10;  // beyond it, the ray's expansion is used too far from its pixel
  constexpr double kMaxSamples = 1e6;
  detail::checkOption("blur_px", blur_px, 0, kMaxBlurPx);
  detail::checkOption("dark_level", dark_level, 0, kMaxLevel);
  detail::checkOption("bright_level", bright_level, 0, kMaxLevel);
  detail::checkOption("background_level", background_level, 0, kMaxLevel);
  detail::checkOption("border_square", border_square, 0.01, 1);
  detail::checkOption("falloff", falloff, 0, 1);
  detail::checkOption("vignetting_exponent", vignetting_exponent, 0, 16);
  detail::checkOption("read_noise", read_noise, 0, kMaxLevel);
  detail::checkOption("full_well_electrons", full_well_electrons, 0, 1e9);
  detail::checkOption("samples", samples, 1, kMaxSamples);
}

void FootageScene::validate() const {
  constexpr int kMaxFrames = 100'000;
  constexpr int kMaxObjects = 1000;
  constexpr double kMaxShare = 0.95;
  expect(image_size.width > 0 && image_size.height > 0, "an image with pixels");
  detail::checkOption("frames", num_frames, 1, kMaxFrames);
  detail::checkOption("frame_rate_hz", frame_rate_hz, 1e-3, 1e6);
  detail::checkOption("flow_px", flow_px, 0, 100);
  detail::checkOption("shake_px", effects.shake_px, 0, 100);
  detail::checkOption("moving_objects", effects.moving_objects, 0, kMaxObjects);
  detail::checkOption("moving_share", effects.moving_share, 0, effects.moving_objects > 0 ? kMaxShare : 0);
  detail::checkOption("rolling_shutter", effects.rolling_shutter, 0, 1);
  detail::checkOption("stabilisation_frames", effects.stabilisation_frames, 0, 1000);
  detail::checkOption("zoom", effects.zoom, 0.1, 10);
  detail::checkOption("blur_px", effects.blur_px, 0, 10);
  detail::checkOption("read_noise", effects.read_noise, 0, 255);
  if (surroundings == FootageSurroundings::kFar && path == FootagePath::kStraight) {
    throw inputError({.where = "path",
                      .found = "'straight' in surroundings that are far away, which shows no motion",
                      .expected = "walk, rotation or static",
                      .next_step = "choose another path, or surroundings: room or plane"});
  }
}

}  // namespace alidade
