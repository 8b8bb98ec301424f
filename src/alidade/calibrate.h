// SPDX-License-Identifier: MIT
/// Calibrates a camera from corners: calibrate() estimates the camera and its uncertainty and reports
/// diagnoses. recordOf() converts the result to the record that saveCamera() writes. Component `calibrate`.
/// Errors are thrown as alidade::Error.
#pragma once

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/record_of.h"
#include "alidade/core/error.h"
