// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/io/formats/camera_format.h"

/// The formats, each defined in a file of its name (ros_format.cc). Where the facts come from stands there.
namespace alidade::formats {

[[nodiscard]] const CameraFormat& alidade();
[[nodiscard]] const CameraFormat& opencv();
[[nodiscard]] const CameraFormat& ros();

}  // namespace alidade::formats
