// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// The covariance of a solved rig: by corner noise, or by frames if these disagree by more than noise.
/// @param given  the cameras whose lenses were kept, or nothing for each that was calibrated; may be empty
[[nodiscard]] RigCovariance rigCovariance(const Fit& fit, std::span<const std::optional<CameraRecord>> given);

/// The links of each camera of a solved rig, and the accuracy of its pose.
[[nodiscard]] std::vector<CameraLink> cameraLinks(const Fit& fit, const RigCovariance& covariance);

}  // namespace alidade
