// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/adjust/noise/correction_fit.h"
#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// A correction field for a solved fit without one: of the requested grid, or of the one with the smallest
/// held-out errors, if these are significantly smaller than without.
/// @returns nothing if the lens needs none, or the corners show none
[[nodiscard]] std::optional<CorrectedFit> chooseCorrection(const Fit& fit, const CalibratorOptions& options,
                                                           CorrectionReport& report);

/// Adds the uncertainty of the field to what is known about the camera of the same fit.
void includeCorrection(const CorrectedFit& corrected, Uncertainty& known);

/// The sizes of the displacements of the corners.
void measureCorrection(const CorrectedFit& corrected, CorrectionReport& report);

}  // namespace alidade
