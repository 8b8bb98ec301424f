// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/files/text/yaml_node.h"
#include "alidade/record/rig_record.h"

// Strict readers of Alidade's camera and rig files: read strictly: unknown, missing, duplicate and misspelt
// keys, wrong types, numbers that are not finite and unknown models are errors that name line, key, found and
// expected.
namespace alidade::detail {

/// Reads {width: ..., height: ...}, pixels.
[[nodiscard]] ImageSize readImageSize(const YamlNode& node);

/// Reads the keys model and parameters of a map (other keys are the caller's to check).
[[nodiscard]] AnyCamera readCamera(const YamlNode& node);

/// Reads a whole camera file, of which only the first four keys are required.
[[nodiscard]] CameraRecord readCameraRoot(const YamlNode& root);

/// Checks the version and the keys of a rig file.
void checkRigRoot(const YamlNode& root);

/// Reads an item of a rig file's `cameras`.
[[nodiscard]] RigCameraRecord readRigCamera(const YamlNode& entry);

/// Reads the rest of a rig file; `rig` already has its cameras and their poses.
void readRigRest(const YamlNode& root, RigRecord& rig);

}  // namespace alidade::detail
