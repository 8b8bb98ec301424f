// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/simulate/ink_pattern.h"

namespace alidade {

enum class BoardTone { kDark, kBright, kBackground };

/// The tone of one place of a print and its paper, metres; anything not finite is background.
inline BoardTone toneAt(const InkPattern& pattern, const Eigen::Vector2d& p) {
  if (!pattern.paper().contains(p)) return BoardTone::kBackground;
  return pattern.isDark(p) ? BoardTone::kDark : BoardTone::kBright;
}

}  // namespace alidade
