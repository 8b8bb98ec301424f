// SPDX-License-Identifier: MIT
#include "commands/calibrate/coverage_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace alidade {

std::string coveragePicture(const CoverageReport& coverage) {
  // Two characters each, because a character is about half as wide as high.
  constexpr std::array<const char*, 6> kCells = {"  ", "··", "░░", "▒▒", "▓▓", "██"};
  const int most = coverage.num_corners.empty() ? 0 : *std::ranges::max_element(coverage.num_corners);
  const auto cellOf = [&](int count) -> std::size_t {
    if (count < 0) return 0;  // no ray
    if (count == 0) return 1;
    const double strength = std::sqrt(static_cast<double>(count) / most);
    return 2 + std::min<std::size_t>(3, static_cast<std::size_t>(4 * strength));
  };
  const std::array<std::string, 2> words = {"the image; the darker, the more corners",
                                            "·· none: put the board there"};
  std::string text;
  for (int row = 0; row < coverage.rows; ++row) {
    text += row == 0 ? "Seen      " : "          ";
    for (int column = 0; column < coverage.columns; ++column)
      text += kCells[cellOf(coverage.num_corners[static_cast<std::size_t>(row * coverage.columns + column)])];
    if (static_cast<std::size_t>(row) < words.size()) text += "   " + words[static_cast<std::size_t>(row)];
    text += "\n";
  }
  return text;
}

}  // namespace alidade
