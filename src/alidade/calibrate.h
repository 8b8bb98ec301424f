// SPDX-License-Identifier: MIT
/// The main header of the component `calibrate`, which needs Ceres.
///
/// calibrate() estimates a camera and its uncertainty from the corners of a Board, and reports
/// diagnoses. Its input is one View per image, from BoardSurvey::views() or filled with corners of your own
/// (target/view.h). CalibratorOptions choose the lens model. Calibration::uncertainty holds the accuracy and
/// the standard deviations, and recordOf() converts the result to the record that saveCamera() writes. Errors
/// are thrown as alidade::Error.
#pragma once

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/record_of.h"
#include "alidade/core/error.h"
