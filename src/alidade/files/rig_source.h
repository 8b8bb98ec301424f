// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/files/camera_source.h"
#include "alidade/record/rig_record.h"

namespace alidade {

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
