// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>

#include "alidade/calibrate/calibrator.h"
#include "alidade/record/camera_record.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// One camera of a solved rig as the joint fit has it: lens, poses, boards and errors, the covariance from
/// all cameras, and the resulting accuracy and diagnoses. Choice, dropped corners and tests of its own views
/// remain those of the camera alone.
/// @param alone       the camera's own calibration
/// @param covariance  of the rig; without it only the fit and what follows from it come from the joint fit
[[nodiscard]] Calibration jointCamera(Calibration alone, const Fit& rig, const RigCovariance& covariance,
                                      std::size_t camera, double tolerance_px, double distance_m);

/// Compares a given lens with the one from a rig's images, at their corners.
/// @param rig  with all lenses freed
/// @returns nothing if the two differ by no more than their covariances explain
[[nodiscard]] std::optional<LensMisfit> givenLensMisfit(const CameraRecord& given, const RigCalibration& rig,
                                                        std::size_t camera);

}  // namespace alidade
