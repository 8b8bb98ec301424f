// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/calibrate/calibration.h"
#include "alidade/record/camera_record.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// What a camera file contains in addition to the result of the calibration.
struct RecordDetails {
  Checkerboard board;                  ///< that the views show
  std::string created_by;              ///< program and version
  std::vector<Setting> settings = {};  ///< effective settings of the program, if they are to be kept
};

/// All that a camera file holds of a calibration: the camera with its domain and self-check points,
/// uncertainty, verdict, findings and views. Write it with saveCamera().
[[nodiscard]] CameraRecord recordOf(const Calibration& calibration, RecordDetails details);

}  // namespace alidade
