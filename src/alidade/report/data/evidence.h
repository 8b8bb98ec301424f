// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/calibrate/calibrator.h"
#include "alidade/guide/coverage.h"
#include "alidade/guide/guidance.h"
#include "alidade/target/view.h"

namespace alidade {

/// The input images of a calibration, as reported in its documents.
struct GivenImages {
  std::size_t num_images = 0;
  std::size_t num_found = 0;         ///< with a board
  std::vector<std::string> reasons;  ///< one line for each image without a board
  std::vector<std::string> notes;
};

/// Advice on the photographs: those that were taken, and the next one.
struct Advice {
  CoverageReport coverage;
  Guidance guidance;
};

/// @param target_px  see guide()
[[nodiscard]] Advice adviceOn(const Calibration& result, const std::vector<View>& views,
                              std::optional<double> target_px = std::nullopt);

/// The number of images with a view in the fit.
[[nodiscard]] std::size_t numImagesUsed(const Calibration& result);

/// All results of a calibration, for programs: one JSON document.
/// @param views  as given to calibrate()
[[nodiscard]] std::string summaryJson(const Calibration& result, const GivenImages& given,
                                      std::span<const View> views, const Advice& advice);

/// Origin of the evidence.
struct EvidenceOrigin {
  std::vector<std::pair<std::string, std::vector<std::string>>> settings = {};  ///< names and values
  double tolerance_px = 1;                                                      ///< see CalibratorOptions
  std::string created_by = {};                                                  ///< program and version
};

/// The same with the settings and the errors of all corners; input of reportPage().
[[nodiscard]] nlohmann::json evidenceDocument(const Calibration& result, const GivenImages& given,
                                              std::span<const View> views, const Advice& advice,
                                              const EvidenceOrigin& origin);

}  // namespace alidade
