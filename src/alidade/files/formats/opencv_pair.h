// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/stated_camera.h"
#include "alidade/geometry/se3.h"

namespace alidade::detail {

/// Is this a file that cv::stereoCalibrate()'s results were written to: R and T? The cameras may be in it
/// too, or in a file of their own, as the sample stereo_calib writes them.
[[nodiscard]] bool statesPair(const CameraDocument& document);

/// second_from_first: X2 = R X1 + T. R is a rotation matrix, or a rotation vector. T is in the unit of the
/// board that was used, which no file states; it is taken as metres, with a remark where it is longer than
/// ordinary rigs are.
/// @throws Error (kInput) with the place
[[nodiscard]] SE3 readPair(const YamlNode& root, std::vector<Remark>& remarks);

}  // namespace alidade::detail
