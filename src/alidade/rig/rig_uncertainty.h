// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/fit.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// Where the unknowns of a rig stand in its covariance: the parameters of each camera, then camera_from_rig
/// of each but the first (SE3's tangent), then the bends of the boards whose shape is free.
struct RigColumns {
  std::vector<int> params;  ///< first column of each camera's parameters
  std::vector<int> pose;    ///< of each camera's pose; -1 for the first camera
  std::vector<int> bend;    ///< of each board's bends; -1 for a fixed shape
  int count = 0;
};
[[nodiscard]] RigColumns rigColumns(const Fit& fit);

/// Sets the covariance of a solved rig and what follows from it for each camera: standard deviations of its
/// pose, and RigCamera::transfer_px. Nothing is set if the frames do not determine the rig.
void setUncertainty(RigCalibration& rig);

}  // namespace alidade
