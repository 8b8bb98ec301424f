// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "alidade/calibrate/calibration.h"
#include "alidade/guide/coverage.h"
#include "alidade/guide/next_view.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// Most further views for which a forecast is made.
inline constexpr int kMaxForecast = 20;

/// How far a calibration is from the uncertainty that is wanted.
struct TargetReport {
  double target_px = 0;
  bool is_reached = false;
  /// How many more views it takes, each the best one after those before it: 0 where it is reached, nothing
  /// where kMaxForecast are not enough or none can be suggested.
  std::optional<int> num_more_views;
  double forecast_px = 0;  ///< the worst uncertainty after those, or after as many as were tried
};

/// What to do next.
struct Guidance {
  /// False where the views leave some direction of the parameters undetermined: `next` is then the view that
  /// tells most about it, and there is no uncertainty yet.
  bool is_determined = false;
  /// The largest standard deviation of a pixel over the image, px, at infinity (ProjectionUncertainty): the
  /// larger of that by the covariance and that by the covariance between views. NaN if not determined.
  double worst_px = 0;
  /// worst_px over that by the covariance alone, 1 or more; forecasts are multiplied by it.
  double inflation = 1;
  std::optional<NextView> next;        ///< nothing where no view would tell anything new
  std::optional<TargetReport> target;  ///< where one was given
};

/// @param target_px  positive
[[nodiscard]] Guidance guide(const Calibration& calibration, const Checkerboard& board,
                             const CoverageReport& coverage, std::optional<double> target_px = std::nullopt);

/// For people: where to put the board, and what that brings. Lines without an indent, with a line end each.
[[nodiscard]] std::string nextViewText(const Guidance& guidance, ImageSize size);
/// The same in one sentence without a line end.
[[nodiscard]] std::string shortNextViewText(const Guidance& guidance, ImageSize size);
[[nodiscard]] std::string targetText(const Guidance& guidance);

}  // namespace alidade
