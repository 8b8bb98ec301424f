// SPDX-License-Identifier: MIT
#include "alidade/detect/board/detection.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/median.h"

namespace alidade {

std::string_view reasonCode(DetectionReason reason) {
  constexpr std::array<std::string_view, 14> kCodes = {
      "found",          "partial",   "cut",     "no_board",  "unplaced",  "larger_board", "other_board",
      "several_boards", "irregular", "blurred", "too_small", "duplicate", "unreadable",   "other_size"};
  return kCodes[static_cast<std::size_t>(reason)];
}

bool SeenGrid::hasCountsOf(int board_columns, int board_rows) const {
  return columns == std::max(board_columns, board_rows) && rows == std::min(board_columns, board_rows);
}

ViewMeasures medianMeasures(std::vector<double> blurs, std::vector<double> spacings,
                            std::vector<double> tilts, double area_px, const ImageSize& size) {
  const auto median = [](std::vector<double>& values) {
    return values.empty() ? std::numeric_limits<double>::quiet_NaN() : medianOf(std::move(values));
  };
  return {.blur_px = median(blurs),
          .spacing_px = median(spacings),
          .area_share = std::min(1.0, area_px / (static_cast<double>(size.width) * size.height)),
          .tilt_deg = median(tilts) * 180 / std::numbers::pi};
}

Detection& Detection::withdraw(DetectionReason why, std::string sentence) {
  reason = why;
  detail = std::move(sentence);
  corners.clear();
  return *this;
}

void Detection::describeMissing(int num_all, std::string_view points,
                                std::span<const Eigen::Vector2d> missing, const ImageSize& size) {
  reason = DetectionReason::kFound;
  if (static_cast<int>(corners.size()) == num_all) return;
  constexpr double kMarginPx = 3;  // closer to the border, no corner is visible
  const Eigen::Array2d last(size.width - 1 - kMarginPx, size.height - 1 - kMarginPx);
  const auto num_inside = std::ranges::count_if(missing, [&](const Eigen::Vector2d& place) {
    return (place.array() >= kMarginPx).all() && (place.array() <= last).all();
  });
  const auto num_outside = static_cast<std::ptrdiff_t>(missing.size()) - num_inside;
  reason = num_outside > num_inside ? DetectionReason::kCut : DetectionReason::kPartial;
  detail = fmt::format("{} of {} {}; the others are {}", corners.size(), num_all, points,
                       num_outside == 0  ? "covered or not clear enough"
                       : num_inside == 0 ? "outside the image"
                                         : "outside the image, covered or not clear enough");
}

}  // namespace alidade
