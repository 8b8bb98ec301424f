// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// Sets the covariance of a solved rig and what follows from it for each camera: standard deviations of its
/// pose, and RigCamera::transfer_px. Nothing is set if the frames do not determine the rig.
void setUncertainty(RigCalibration& rig);

}  // namespace alidade
