// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// Judges everything in a rig except `diagnoses`, and repeats the diagnoses of its cameras' own calibrations;
/// failures first.
[[nodiscard]] std::vector<Diagnosis> judgeRig(const RigCalibration& rig, double tolerance_px);

}  // namespace alidade
