// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/stated_camera.h"
#include "alidade/geometry/se3.h"

namespace alidade::detail {

/// True if the file holds results of cv::stereoCalibrate(): R and T. The cameras may be in the same file, or
/// in a separate one as the sample stereo_calib writes them.
[[nodiscard]] bool statesPair(const CameraDocument& document);

/// second_from_first: X2 = R X1 + T. R is a rotation matrix or a rotation vector. T is in the unit of the
/// board, which no file states; metres are assumed, with a remark if it is longer than usual for rigs.
/// @throws Error (kInput) with the place
[[nodiscard]] SE3 readPair(const YamlNode& root, std::vector<Remark>& remarks);

}  // namespace alidade::detail
