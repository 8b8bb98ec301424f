// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/record/rig_record.h"

namespace alidade {

/// Text of a rig file (YAML, `alidade_rig: 1`). Each camera is there as in a camera file, so loadCameras()
/// reads the cameras of a rig file.
[[nodiscard]] std::string rigFileText(const RigRecord& rig);

}  // namespace alidade
