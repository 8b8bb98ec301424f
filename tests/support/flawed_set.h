// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "support/user_views.h"

namespace alidade {

/// Photographs of a board by a camera of one's own with something wrong, and the true camera.
struct FlawedSet {
  DrawnCamera drawn;
  UserSet set;
  double noise_px = 0;
};

/// Photographs the board again, each with a flaw of a kind. Most take a size, which is drawn so that the
/// flaw is anything from invisible to gross.
struct FlawKind {
  std::string_view name;
  void (*apply)(FlawedSet& set, Random& random);
};

/// What goes wrong with calibrations, the first without a flaw.
[[nodiscard]] std::span<const FlawKind> flawKinds();

/// A camera of 50 to 90 degrees (radtan) or 90 to 135 degrees (kannala_brandt), 8 to 30 views, noise of 0.05
/// to 0.3 px.
[[nodiscard]] FlawedSet drawFlawedSet(const FlawKind& kind, std::string_view model, std::uint64_t seed);

}  // namespace alidade
