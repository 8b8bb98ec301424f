// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "alidade/calibrate/calibration.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// A camera of a solved rig by itself, as the joint fit has it: lens, poses, boards and errors, the
/// covariance by all cameras, and the accuracy and the diagnoses that follow. How it was found (Choice), what
/// was dropped, and what tests of its own views say are those of the camera alone.
/// @param rig  with its covariance; without one only the fit and what follows from it are the joint one's
[[nodiscard]] Calibration jointCamera(const RigCalibration& rig, std::size_t camera, double tolerance_px,
                                      double distance_m);

}  // namespace alidade
