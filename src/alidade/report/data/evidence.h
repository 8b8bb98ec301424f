// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/calibrate/calibrator.h"
#include "alidade/guide/guidance.h"
#include "alidade/report/data/report_data.h"
#include "alidade/rig/rig_calibration.h"
#include "alidade/target/view.h"

namespace alidade {

/// The input images of a calibration, as reported in its documents.
struct GivenImages {
  std::size_t num_images = 0;
  std::size_t num_found = 0;         ///< with a board
  std::vector<std::string> reasons;  ///< one line for each image without a board
  std::vector<std::string> notes;
};

/// The number of images with a view in the fit.
[[nodiscard]] std::size_t numImagesUsed(const Calibration& result);

/// All results of a calibration, for programs: one JSON document.
[[nodiscard]] std::string summaryJson(const Calibration& result, const GivenImages& given,
                                      const Guidance& guidance);

/// What a calibration was given.
struct EvidenceOrigin {
  std::vector<std::pair<std::string, std::vector<std::string>>> settings = {};  ///< names and values
  double tolerance_px = 1;                                                      ///< see CalibratorOptions
  RunOrigin run = {};
};

/// The same with the settings and the errors of all corners; input of reportPage().
[[nodiscard]] nlohmann::json evidenceDocument(const Calibration& result, const GivenImages& given,
                                              const Guidance& guidance, const EvidenceOrigin& origin);

/// All results of the calibration of a rig, for programs: one JSON document.
[[nodiscard]] std::string rigSummaryJson(const RigCalibration& rig);

/// The same with boards, frames and the errors of all corners; input of reportPage().
/// @param tolerance_px  see CalibratorOptions
[[nodiscard]] nlohmann::json rigEvidenceDocument(const RigCalibration& rig, double tolerance_px,
                                                 const RunOrigin& origin);

}  // namespace alidade
