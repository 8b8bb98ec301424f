// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/record/camera_record.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// Compares a lens that was given with the one that a rig's images give, at their corners.
/// @param rig  with all lenses freed
/// @returns nothing if the two differ by no more than their covariances explain
[[nodiscard]] std::optional<LensMisfit> givenLensMisfit(const CameraRecord& given, const RigCalibration& rig,
                                                        std::size_t camera);

}  // namespace alidade
