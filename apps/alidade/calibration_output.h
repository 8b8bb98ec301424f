// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/calibrate/calibration.h"
#include "alidade/guide/coverage.h"
#include "alidade/guide/guidance.h"
#include "board_views.h"
#include "options.h"

namespace alidade {

/// What a calibration tells about the photographs: those that were taken, and the next one.
struct Advice {
  CoverageReport coverage;
  Guidance guidance;
};

struct SummaryStyle {
  double tolerance_px = 1;
  bool is_coloured = false;  ///< for a terminal
};

/// The number of images with a view in the fit.
[[nodiscard]] std::size_t numImagesUsed(const Calibration& result);

/// The summary of a calibration for people: at most 16 lines of at most 100 columns, the verdict and the
/// accuracy first.
[[nodiscard]] std::string summaryText(const Calibration& result, const GivenViews& given,
                                      const Advice& advice, const SummaryStyle& style);

/// What --verbose adds to the summary.
[[nodiscard]] std::string detailsText(const Calibration& result, const GivenViews& given,
                                      const Advice& advice);

/// Everything for programs: one JSON document.
[[nodiscard]] std::string summaryJson(const Calibration& result, const GivenViews& given,
                                      const Advice& advice);

/// The same with the effective settings and the errors of all corners.
[[nodiscard]] std::string evidenceJson(const Calibration& result, const GivenViews& given,
                                       const Advice& advice, const std::vector<Setting>& settings,
                                       double tolerance_px);

}  // namespace alidade
