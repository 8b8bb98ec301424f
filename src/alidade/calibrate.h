// SPDX-License-Identifier: MIT
/// Calibrates a camera from corners: calibrate() finds camera, uncertainty and findings, and recordOf() makes
/// of them what saveCamera() writes. Component `calibrate`.
#pragma once

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/record_of.h"
