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
#include "alidade/rig/rig_calibration.h"
#include "alidade/target/view.h"

namespace alidade {

/// What a calibration was given, as far as its documents tell about it.
struct GivenImages {
  std::size_t num_images = 0;
  std::size_t num_found = 0;         ///< with a board
  std::vector<std::string> reasons;  ///< a line for each image without one
  std::vector<std::string> notes;
};

/// The number of images with a view in the fit.
[[nodiscard]] std::size_t numImagesUsed(const Calibration& result);

/// Everything that a calibration found out, for programs: one JSON document.
/// @param views  that calibrate() was given
[[nodiscard]] std::string summaryJson(const Calibration& result, const GivenImages& given,
                                      std::span<const View> views, const Guidance& guidance);

/// What made the evidence.
struct EvidenceOrigin {
  std::vector<std::pair<std::string, std::vector<std::string>>> settings = {};  ///< names and values
  double tolerance_px = 1;                                                      ///< see CalibratorOptions
  std::string created_by = {};                                                  ///< program and version
};

/// The same with the settings and the errors of all corners: what reportPage() draws.
[[nodiscard]] nlohmann::json evidenceDocument(const Calibration& result, const GivenImages& given,
                                              std::span<const View> views, const Guidance& guidance,
                                              const EvidenceOrigin& origin);

/// Everything that the calibration of a rig found out, for programs: one JSON document.
[[nodiscard]] std::string rigSummaryJson(const RigCalibration& rig);

/// The same with boards, frames and the errors of all corners: what reportPage() draws.
/// @param tolerance_px  see CalibratorOptions
/// @param created_by    program and version
[[nodiscard]] nlohmann::json rigEvidenceDocument(const RigCalibration& rig, double tolerance_px,
                                                 const std::string& created_by);

}  // namespace alidade
