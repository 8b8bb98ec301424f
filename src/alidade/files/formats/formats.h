// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/files/formats/camera_format.h"

/// The formats, each defined in a file of its name (ros_format.cc). Where the facts come from stands there.
namespace alidade::formats {

[[nodiscard]] const CameraFormat& alidade();
[[nodiscard]] const CameraFormat& basalt();
[[nodiscard]] const CameraFormat& camodocal();
[[nodiscard]] const CameraFormat& colmap();
[[nodiscard]] const CameraFormat& kalibr();
[[nodiscard]] const CameraFormat& matlab();
[[nodiscard]] const CameraFormat& mrcal();
[[nodiscard]] const CameraFormat& nerfstudio();
[[nodiscard]] const CameraFormat& opencv();
[[nodiscard]] const CameraFormat& orbslam();
[[nodiscard]] const CameraFormat& ros();

}  // namespace alidade::formats
