// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace alidade {

/// Keeps the results of the more frequent colour: a board is dark on white or white on dark, not both.
/// @param isDark  for an index and the result at it
template <class Found, class F>
void keepOneColour(std::vector<std::optional<Found>>& found, const F& isDark) {
  int balance = 0;
  for (std::size_t i = 0; i < found.size(); ++i) balance += found[i] ? (isDark(i, *found[i]) ? 1 : -1) : 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i] && (isDark(i, *found[i]) ? 1 : -1) * balance < 0) found[i].reset();
  }
}

}  // namespace alidade
