// SPDX-License-Identifier: MIT
/// The main header of the component `calibrate`, which needs Ceres.
///
/// calibrate() estimates a camera and its uncertainty from the corners of a Board, and reports
/// diagnoses. Its input is one View per image, from BoardSurvey::views() or filled with corners of your own
/// (target/view.h). CalibratorOptions choose the lens model. Calibration::uncertainty holds the accuracy and
/// the standard deviations, and recordOf() converts the result to the record that saveCamera() writes. Errors
/// are thrown as alidade::Error.
///
///     const alidade::Checkerboard board{.columns = 9, .rows = 6, .square_m = 0.025};
///     alidade::View view{.image = "1.png", .size = {640, 480}};
///     view.corners.push_back({.id = 0, .pixel = {102.3, 87.1}});
///     const std::vector<alidade::View> views = {view};  // one per image
///     const alidade::Calibration result = alidade::calibrate(board, views, {.model = "radtan"});
///     for (const alidade::Diagnosis& diagnosis : result.diagnoses) std::puts(diagnosis.message().c_str());
///     if (result.isUsable()) std::printf("fx +- %.2f px\n", result.uncertainty.parameterStd(0));
///     const auto record = alidade::recordOf(result, "my program");
#pragma once

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/error.h"
