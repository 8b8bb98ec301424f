// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/adjust/noise/correction_fit.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/start/calibration_options.h"

namespace alidade {

/// A correction field for a calibration without one: of the requested grid, or of the one with the smallest
/// held-out errors, if these are significantly smaller than without.
/// @returns nothing if the lens needs none, or the corners show none
[[nodiscard]] std::optional<CorrectedFit> chooseCorrection(const Calibration& of,
                                                           const CalibratorOptions& options,
                                                           CorrectionReport& report);

/// Gives the camera of a calibration of corners that are free of the field this field.
void setCorrection(CorrectionPointer field, Calibration& calibration);

/// Adds the field to a calibration of corners that are free of it: to its camera, and the field's own
/// uncertainty to what is known about the camera.
/// @param corrected  the same fit with its field
void attachCorrection(const CorrectedFit& corrected, Calibration& calibration);

}  // namespace alidade
