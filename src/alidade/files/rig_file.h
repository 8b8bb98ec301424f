// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/files/camera_source.h"
#include "alidade/record/rig_record.h"

namespace alidade {

/// Reads a file that says where several cameras are; Alidade's own are read whole.
/// @throws Error (kInput) as loadCameras(), and for a file without poses
[[nodiscard]] RigRecord loadRig(const std::string& path);

/// The rig that the cameras of `source` are, of which all have poses, with all that an Alidade rig file
/// states of it. Nothing is recomputed here.
[[nodiscard]] RigRecord rigOf(const CameraSource& source);

/// Checks that a camera of the file `path` has a pose. @throws Error (kInput) with the reason if it has none
void requirePose(const StatedCamera& camera, const std::string& path);

/// Writes a rig file: it is there as a whole or not at all.
/// @throws Error (kInput) if it cannot be written
void saveRig(const std::string& path, const RigRecord& rig);

}  // namespace alidade
