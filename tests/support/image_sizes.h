// SPDX-License-Identifier: MIT
// The image sizes that most tests use. One name for all, because test sources are compiled several at a time.
#pragma once

#include "alidade/core/image.h"

namespace alidade {

inline constexpr ImageSize kVga{.width = 640, .height = 480};
inline constexpr ImageSize kQuadVga{.width = 1280, .height = 960};

}  // namespace alidade
