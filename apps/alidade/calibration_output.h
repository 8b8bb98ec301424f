// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "advice_output.h"
#include "alidade/calibrate/calibration_result.h"
#include "alidade/files/camera_file.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// What was given to a calibration, for the reports.
struct CalibrationInput {
  Checkerboard board;
  std::size_t num_images = 0;        ///< given
  std::size_t num_found = 0;         ///< with a board
  std::string measures;              ///< how the images show the board; empty if that is not known
  std::vector<std::string> reasons;  ///< a line an image without one
  std::vector<std::string> notes;
};

/// The camera file of a result.
[[nodiscard]] CameraRecord cameraFileOf(const CalibrationResult& result, const CalibrationInput& input,
                                        std::vector<Setting> settings);

/// The summary for people.
[[nodiscard]] std::string summaryText(const CalibrationResult& result, const CalibrationInput& input,
                                      const Advice& advice);

/// The same for programs: one JSON document.
[[nodiscard]] std::string summaryJson(const CalibrationResult& result, const CalibrationInput& input,
                                      const Advice& advice);

}  // namespace alidade
