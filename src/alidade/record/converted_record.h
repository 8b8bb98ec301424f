// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/camera_edit.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// What a calibration says of the camera of an edited image. Parameters, covariance and poses follow the edit
/// exactly; RMS values count pixels of the new size, and where the axes were resized unequally take the
/// geometric mean of both scales. What the covariance means in the image is
/// found anew. Image names, counts, board, findings and settings stay: they tell how the
/// calibration came about.
/// @param edit  from the calibrated camera to the new one, all steps in one
[[nodiscard]] CalibrationRecord editedRecord(const CalibrationRecord& record, const AnyCamera& calibrated,
                                             const EditedCamera& edit);

/// What it says of a camera of another model in its place, off by `fit_rms_px`. The old parameters'
/// covariance and the views, whose errors are not the new model's, are left out; the RMS is that of both
/// errors together.
[[nodiscard]] CalibrationRecord refittedRecord(CalibrationRecord record, double fit_rms_px);

}  // namespace alidade
