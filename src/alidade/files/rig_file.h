// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/files/camera_source.h"
#include "alidade/record/rig_record.h"

namespace alidade {

/// Reads a file that says where several cameras are; Alidade's own are read whole.
/// @throws Error (kInput) as loadCameras(), and for a file without poses
[[nodiscard]] RigRecord loadRig(const std::string& path);

/// The rig that the cameras of `source` are, of which all have poses. Of an Alidade file of more than one
/// camera, the rest is read from the file. Nothing is recomputed here.
[[nodiscard]] RigRecord rigOf(const CameraSource& source);

/// Checks that a camera of the file `path` has a pose. @throws Error (kInput) with the reason if it has none
void requirePose(const StatedCamera& camera, const std::string& path);

/// Text of a rig file (YAML, `alidade_rig: 1`). Each camera is there as in a camera file, so loadCameras()
/// reads the cameras of a rig file.
[[nodiscard]] std::string rigFileText(const RigRecord& rig);

/// Writes a rig file: it is there as a whole or not at all.
/// @throws Error (kInput) if it cannot be written
void saveRig(const std::string& path, const RigRecord& rig);

}  // namespace alidade
