// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/record/rig_record.h"
#include "alidade/validate/camera_checks.h"

namespace alidade {

/// Checks the poses of a rig's cameras, its verdict, and its covariance. Values that are not stated are not
/// checked.
/// @pre two cameras or more
[[nodiscard]] std::vector<FileCheck> checkRig(const RigRecord& rig);

/// The same for the cameras of a file; nothing if the file is no rig of supported cameras. Files of other
/// tools need no image size.
[[nodiscard]] std::vector<FileCheck> checkRig(const CameraSource& source);

}  // namespace alidade
