// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibration.h"

#include <algorithm>
#include <cmath>

namespace alidade {

AnyCamera Calibration::camera() const {
  return AnyCamera::make(onlyCamera(fit).model, onlyCamera(fit).params);
}

std::vector<ViewSummary> viewSummaries(const Calibration& calibration) {
  std::vector<ViewSummary> summaries;
  auto outlier = calibration.dropped.outliers.begin();
  for (const FitView& view : calibration.fit.views) {
    ViewSummary summary{.image = view.image,
                        .board = boardIndex(calibration.fit, view),
                        .num_corners = static_cast<int>(view.errors.size())};
    double sum = 0;
    for (const Eigen::Vector2d& error : view.errors) {
      sum += error.squaredNorm();
      summary.max_error_px = std::max(summary.max_error_px, error.norm());
    }
    summary.rms_px = std::sqrt(sum / summary.num_corners);
    // Outliers are in the order of their views.
    for (; outlier != calibration.dropped.outliers.end() && outlier->source == view.source; ++outlier)
      ++summary.num_outliers;
    summaries.push_back(std::move(summary));
  }
  return summaries;
}

}  // namespace alidade
