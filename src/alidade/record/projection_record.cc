// SPDX-License-Identifier: MIT
#include "alidade/record/projection_record.h"

#include <array>
#include <charconv>
#include <cmath>

namespace alidade {
namespace {

double rounded(double value) {
  if (!std::isfinite(value)) return value;
  constexpr int kDigits = 4;
  std::array<char, 32> text{};
  const auto written =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, kDigits);
  std::from_chars(text.data(), written.ptr, value);
  return value;
}

}  // namespace

std::optional<ProjectionStdRecord> projectionRecord(const UncertaintyGrid& grid) {
  if (!std::isfinite(grid.worst_px)) return std::nullopt;
  ProjectionStdRecord record{.center_px = rounded(grid.center_px),
                             .worst_px = rounded(grid.worst_px),
                             .worst_pixel = grid.worst_pixel,
                             .columns = grid.columns,
                             .rows = grid.rows,
                             .std_px = {}};
  for (const double std : grid.std_px) record.std_px.push_back(rounded(std));
  return record;
}

}  // namespace alidade
