// SPDX-License-Identifier: MIT
/// The main header of the component `calibrate`, which needs Ceres.
///
/// calibrate() estimates a camera and its uncertainty from corners, and reports diagnoses. recordOf()
/// converts the result to the record that saveCamera() writes. Errors are thrown as alidade::Error.
#pragma once

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/record_of.h"
#include "alidade/core/error.h"
