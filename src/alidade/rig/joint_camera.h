// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>

#include "alidade/calibrate/calibrator.h"
#include "alidade/record/camera_record.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// A camera of a solved rig by itself, as the joint fit has it: lens, poses, boards and errors, the
/// covariance by all cameras, and the accuracy and the diagnoses that follow. How it was found (Choice), what
/// was dropped, and what tests of its own views say are those of the camera alone.
/// @param alone       the camera's own calibration
/// @param covariance  of the rig; without one only the fit and what follows from it are the joint one's
[[nodiscard]] Calibration jointCamera(Calibration alone, const Fit& rig, const RigCovariance& covariance,
                                      std::size_t camera, double tolerance_px, double distance_m);

/// Compares a lens that was given with the one that a rig's images give, at their corners.
/// @param rig  with all lenses freed
/// @returns nothing if the two differ by no more than their covariances explain
[[nodiscard]] std::optional<LensMisfit> givenLensMisfit(const CameraRecord& given, const RigCalibration& rig,
                                                        std::size_t camera);

}  // namespace alidade
