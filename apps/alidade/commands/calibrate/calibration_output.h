// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/calibrate/calibration.h"
#include "alidade/report/data/evidence.h"
#include "board_views.h"
#include "options.h"

namespace alidade {

struct SummaryStyle {
  double tolerance_px = 1;
  bool is_coloured = false;  ///< for a terminal
};

/// The summary of a calibration for people: at most 16 lines of at most 100 columns, the verdict and the
/// accuracy first.
[[nodiscard]] std::string summaryText(const Calibration& result, const GivenViews& given,
                                      const Advice& advice, const SummaryStyle& style);

/// What --verbose adds to the summary.
[[nodiscard]] std::string detailsText(const Calibration& result, const GivenViews& given,
                                      const Advice& advice);

}  // namespace alidade
