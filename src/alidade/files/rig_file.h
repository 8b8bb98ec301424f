// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

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

/// The cameras of one file, or of several files that make up a rig.
struct GatheredCameras {
  CameraSource source;             ///< all cameras, named or numbered; the path is that of the first file
  std::vector<std::string> where;  ///< one text per camera for messages: "left.cameramodel", "rig.yaml#left"
  std::optional<RigRecord> rig = {};  ///< if the file is a complete Alidade rig file
};

/// Reads one file as loadCameras() does, or the files of a rig: each with one camera ("FILE#NAME" too) and
/// its pose in a common frame (mrcal, ROS, a camera of a rig), or the two files of OpenCV's sample
/// stereo_calib, of which one has the lenses and the other R and T. Cameras of several files are named by the
/// files' content, or else by the files or their folders.
/// @param paths  at least one
/// @throws Error (kInput) as loadCameras(), and for files that do not belong together
[[nodiscard]] GatheredCameras gatherCameras(std::span<const std::string> paths, const ReadOptions& options);

}  // namespace alidade
