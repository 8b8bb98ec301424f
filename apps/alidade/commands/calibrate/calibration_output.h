// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/calibrate/calibrator.h"
#include "alidade/report/data/evidence.h"
#include "board_views.h"

namespace alidade {

/// The summary of a calibration for people: at most 16 lines of at most 100 columns, the verdict and the
/// accuracy first.
/// @param is_coloured  true for a terminal
/// @param is_verbose   true if detailsText() follows, which tells boards, views and diagnoses in full
[[nodiscard]] std::string summaryText(const Calibration& result, const GivenViews& given,
                                      const Guidance& guidance, double tolerance_px, bool is_coloured,
                                      bool is_verbose);

/// The details that --verbose adds to the summary.
[[nodiscard]] std::string detailsText(const Calibration& result, const GivenViews& given,
                                      const Guidance& guidance);

/// A text picture of the image for a terminal that shows where corners were seen: the darker a cell, the more
/// corners; a dot for none. One line per row of cells, each with a line end.
[[nodiscard]] std::string coveragePicture(const CoverageReport& coverage);

}  // namespace alidade
