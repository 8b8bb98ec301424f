// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// All results of the calibration of a rig, for programs: one JSON document.
[[nodiscard]] std::string rigSummaryJson(const RigCalibration& rig);

/// The same with boards, frames and the errors of all corners; input of reportPage().
/// @param tolerance_px  see CalibratorOptions
/// @param created_by    program and version
[[nodiscard]] nlohmann::json rigEvidenceDocument(const RigCalibration& rig, double tolerance_px,
                                                 const std::string& created_by);

}  // namespace alidade
