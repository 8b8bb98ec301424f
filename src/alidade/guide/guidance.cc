// SPDX-License-Identifier: MIT
#include "alidade/guide/guidance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "alidade/camera/projection_uncertainty.h"

namespace alidade {
namespace {

constexpr double kReach = 2;  // how much nearer and farther than so far a user can go

// Whether the board's columns run along the image's height in most views.
bool isHeldUpright(const Fit& fit) {
  const auto num_upright = std::count_if(fit.views.begin(), fit.views.end(), [&](const FitView& view) {
    const Eigen::Vector3d along_columns = cameraFromBoard(fit, view).rotation * Eigen::Vector3d::UnitX();
    return std::abs(along_columns.y()) > std::abs(along_columns.x());
  });
  return 2 * static_cast<std::size_t>(num_upright) > fit.views.size();
}

// Worst uncertainty by the stated covariance over that by noise alone, 1 or more.
double inflationOf(const AnyCamera& camera, ImageSize size, const Uncertainty& known) {
  if (!known.covariance) return 1;
  const ProjectionUncertainty uncertainty(camera, size, std::numeric_limits<double>::infinity());
  const double ratio =
      uncertainty.worst(known.statedCovariance()).std_px / uncertainty.worst(*known.covariance).std_px;
  return std::isfinite(ratio) ? std::max(1.0, ratio) : 1;
}

TargetReport forecast(NextViewSearch search, const Guidance& guidance, double target_px) {
  TargetReport report{.target_px = target_px,
                      .is_reached = guidance.worst_px <= target_px,
                      .num_more_views = std::nullopt,
                      .forecast_px = guidance.worst_px};
  if (report.is_reached) report.num_more_views = 0;
  for (int i = 1; i <= kMaxForecast && !report.num_more_views; ++i) {
    const auto view = search.best();
    if (!view) return report;
    search.take(*view);
    report.forecast_px = guidance.inflation * view->worst_px;
    if (report.forecast_px <= target_px) report.num_more_views = i;
  }
  return report;
}

}  // namespace

Guidance guide(const Calibration& calibration, const Checkerboard& board, const CoverageReport& coverage,
               std::optional<double> target_px) {
  const Uncertainty& known = calibration.uncertainty;
  const CameraKnowledge knowledge{.camera = calibration.camera(),
                                  .size = calibration.imageSize(),
                                  .information = known.information,
                                  .directions = known.free_directions,
                                  .variance = known.coordinate_sigma_px * known.coordinate_sigma_px};
  const NextViewSearch search(knowledge, board,
                              {.nearest_m = coverage.nearest_m / kReach,
                               .farthest_m = coverage.farthest_m * kReach,
                               .is_upright = isHeldUpright(calibration.fit)});
  Guidance guidance;
  guidance.is_determined = search.isDetermined();
  guidance.inflation = inflationOf(knowledge.camera, knowledge.size, known);
  guidance.worst_px =
      search.isDetermined() ? guidance.inflation * search.worst() : std::numeric_limits<double>::quiet_NaN();
  guidance.next = search.best();
  if (target_px) guidance.target = forecast(search, guidance, *target_px);
  if (guidance.next) guidance.next->worst_px *= guidance.inflation;
  return guidance;
}

std::string nextViewText(const Guidance& guidance, ImageSize size) {
  if (!guidance.next) return "no further view of this board would improve the camera\n";
  const NextView& next = *guidance.next;
  const BoardSighting& at = next.sighting;
  std::string text = fmt::format(
      "the board{} {} of the image, its centre at pixel ({:.0f}, {:.0f}), {:.2g} m away so that it fills "
      "{:.0f} % of the image{}, {}\n",
      next.is_on_end ? ", upright (portrait)," : "", placeName(regionAt(at.middle_px, size)),
      at.middle_px.x(), at.middle_px.y(), at.distance_m, 100 * next.fill,
      next.is_whole ? "" : " and extends beyond it", tiltText(at.tilt));
  text += guidance.is_determined
              ? fmt::format("reduces the worst projection uncertainty from {:.2g} to {:.2g} px\n",
                            guidance.worst_px, next.worst_px)
              : "adds most to what these views leave undetermined\n";
  return text;
}

std::string shortNextViewText(const Guidance& guidance, ImageSize size) {
  if (!guidance.next) return "no further view of this board would improve the camera";
  const BoardSighting& at = guidance.next->sighting;
  return fmt::format("put the board{} {} of the image, {:.2g} m away, {}",
                     guidance.next->is_on_end ? " upright" : "", placeName(regionAt(at.middle_px, size)),
                     at.distance_m, tiltText(at.tilt));
}

std::string targetText(const Guidance& guidance) {
  if (!guidance.target) return "";
  const TargetReport& target = *guidance.target;
  const std::string now = guidance.is_determined ? fmt::format("{:.2g} px", guidance.worst_px) : "unknown";
  if (target.is_reached)
    return fmt::format("{:.3g} px: reached; the worst projection uncertainty is {}\n", target.target_px, now);
  const std::string text =
      fmt::format("{:.3g} px: not reached; the worst projection uncertainty is {}; ", target.target_px, now);
  if (!target.num_more_views) {
    return text + fmt::format("even {} more views like the suggested one are not enough ({:.2g} px)\n",
                              kMaxForecast, target.forecast_px);
  }
  return text + fmt::format("needs about {} more view{} like the suggested one\n", *target.num_more_views,
                            *target.num_more_views == 1 ? "" : "s");
}

}  // namespace alidade
