// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/record/camera_record.h"
#include "alidade/record/rig_record.h"

namespace alidade {

/// Text of an Alidade camera file. Every number has the fewest digits that read back as the same double.
[[nodiscard]] std::string cameraFileText(const CameraRecord& file);

/// Text of a rig file (YAML, `alidade_rig: 1`). Each camera is written as in a camera file, so loadCameras()
/// reads the cameras of a rig file.
[[nodiscard]] std::string rigFileText(const RigRecord& rig);

}  // namespace alidade
