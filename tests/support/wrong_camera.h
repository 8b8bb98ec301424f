// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// Ways in which a camera file may be wrong although poses make up for nearly all of it.
enum class Wrong { kNot, kFocal, kCenter, kDistortion };
inline constexpr std::array kAllWrongs = {Wrong::kNot, Wrong::kFocal, Wrong::kCenter, Wrong::kDistortion};

[[nodiscard]] constexpr std::string_view wrongName(Wrong wrong) {
  switch (wrong) {
    case Wrong::kNot:
      return "true";
    case Wrong::kFocal:
      return "focal +1 %";
    case Wrong::kCenter:
      return "cx +5 px";
    case Wrong::kDistortion:
      return "distortion x 0.9";
  }
  return "";
}

/// The camera with fx and fy 1 % too long, cx 5 px too large, or all parameters of the lens times 0.9.
[[nodiscard]] inline AnyCamera spoiled(const AnyCamera& camera, Wrong wrong) {
  std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
  if (wrong == Wrong::kFocal) params[0] *= 1.01;
  if (wrong == Wrong::kFocal) params[1] *= 1.01;
  if (wrong == Wrong::kCenter) params[2] += 5;
  if (wrong == Wrong::kDistortion) {
    for (std::size_t i = 4; i < params.size(); ++i) params[i] *= 0.9;
  }
  return AnyCamera::make(camera.modelId(), params);
}

}  // namespace alidade
