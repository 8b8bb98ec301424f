// SPDX-License-Identifier: MIT
#include "alidade/record/footage_scene.h"

#include "alidade/core/error.h"
#include "alidade/record/scene.h"

namespace alidade {

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
