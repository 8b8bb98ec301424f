// SPDX-License-Identifier: MIT
/// Calibrates a camera from corners: calibrate() finds the camera, its uncertainty and the diagnoses, and
/// recordOf() makes of them what saveCamera() writes. Component `calibrate`. Errors are alidade::Error.
#pragma once

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/record_of.h"
#include "alidade/core/error.h"
