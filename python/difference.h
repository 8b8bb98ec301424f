// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "alidade/compare/projection_difference.h"
#include "alidade/record/camera_record.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade::python {

/// Two cameras and their difference.
struct DifferenceValue {
  CameraRecord a;
  CameraRecord b;
  ProjectionDifference difference;
  std::optional<DifferenceSignificance> significance = {};
};

/// Nothing if the cameras have too little in common. @throws Error as projectionDifference()
[[nodiscard]] std::optional<DifferenceValue> tryDifference(const CameraRecord& a, const CameraRecord& b,
                                                           const DifferenceOptions& options);

/// The map of the difference over the image of a. @param name  file name
[[nodiscard]] FigureFile figureOf(const DifferenceValue& value, const std::string& name);

}  // namespace alidade::python
