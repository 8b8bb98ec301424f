// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/stated_camera.h"

namespace alidade {

/// The files of two cameras in a format that states their poses through their rectification: that of `alidade
/// rig rectify` without flags, whose first camera is the left or upper one. The texts are read back before
/// they are returned; lenses and poses must be the same.
/// @param pair  two cameras with poses and different names; `where` is a text for messages
/// @returns the texts in the order of the cameras
/// @throws Error (kInput) for cameras of two image sizes, as rectify(), and as formatText()
[[nodiscard]] std::vector<std::string> rectifiedPairTexts(const CameraFormat& format,
                                                          std::vector<NamedCamera> pair);

/// The name of a camera as a file or folder name.
[[nodiscard]] std::string fileNameOf(const std::string& camera);

}  // namespace alidade
