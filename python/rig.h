// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/record/rig_record.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade::python {

/// A calibrated rig in Python.
struct RigValue {
  RigCalibration result;
  RigRecord record;
  double tolerance_px = 1;
};

}  // namespace alidade::python
