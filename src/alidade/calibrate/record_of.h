// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/calibrate/calibration.h"
#include "alidade/record/camera_record.h"
#include "alidade/target/board.h"

namespace alidade {

/// What a camera file contains in addition to the result of the calibration.
struct RecordDetails {
  Board board = {};        ///< of no effect: the calibration knows its boards
  std::string created_by;  ///< program and version
  CameraName name = {};
};

/// All that a camera file holds of a calibration: the camera with its domain and self-check points,
/// accuracy, covariance, verdict and findings. Write it with saveCamera().
[[nodiscard]] CameraRecord recordOf(const Calibration& calibration, RecordDetails details);

}  // namespace alidade
