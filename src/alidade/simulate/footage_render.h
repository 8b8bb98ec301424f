// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/record/footage_scene.h"
#include "alidade/simulate/footage_frame.h"
#include "alidade/simulate/scene_bodies.h"

namespace alidade {

/// The picture of a frame. Each pixel has 2 x 2 rays, and its light is the mean of all rays near it, weighted
/// by the blur of the lens and the square of the pixel. The texture has no detail finer than a pixel.
/// @param noise_seed  of this frame
/// @throws Cancelled once `cancel` is set
[[nodiscard]] GrayImage renderFootageFrame(const FootageScene& scene, const std::vector<SceneBody>& bodies,
                                           const FootageFrame& frame, std::uint64_t noise_seed,
                                           const CancelFlag* cancel);

}  // namespace alidade
