// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/files/camera_source.h"
#include "alidade/record/rig_record.h"

namespace alidade {

/// Reads a file that states the poses of several cameras; Alidade's own rig files are read completely.
/// @throws Error (kInput) as loadCameras(), and for a file without poses
[[nodiscard]] RigRecord loadRig(const std::string& path);

/// The rig of the cameras of `source`, all of which have poses, with everything that an Alidade rig file
/// states about it. Nothing is recomputed.
[[nodiscard]] RigRecord rigOf(const CameraSource& source);

/// Checks that a camera of the file `path` has a pose. @throws Error (kInput) with the reason otherwise
void requirePose(const StatedCamera& camera, const std::string& path);

/// Writes a rig file atomically.
/// @throws Error (kInput) if it cannot be written
void saveRig(const std::string& path, const RigRecord& rig);

}  // namespace alidade
