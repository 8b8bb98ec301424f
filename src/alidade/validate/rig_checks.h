// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/record/rig_record.h"
#include "alidade/validate/camera_checks.h"

namespace alidade {

/// Checks where the cameras of a rig are to each other, its verdict, and its covariance. What is not stated
/// is not checked.
/// @pre two cameras or more
[[nodiscard]] std::vector<FileCheck> checkRig(const RigRecord& rig);

/// The same for the cameras of a file; nothing for a file that is no rig of supported cameras. A file of
/// another tool needs no image size.
[[nodiscard]] std::vector<FileCheck> checkRig(const CameraSource& source);

}  // namespace alidade
