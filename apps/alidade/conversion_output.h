// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "conversion.h"

namespace alidade {

/// "(12.0, 34.5)"
[[nodiscard]] std::string pixelText(const Eigen::Vector2d& pixel);

/// What was done and what came out, for people; without an end of line.
[[nodiscard]] std::string conversionSummary(const std::string& path, const CameraRecord& source,
                                            const Conversion& conversion, const CameraRecord& file);

/// The same for programs.
[[nodiscard]] nlohmann::json conversionJson(const std::string& path, const CameraRecord& source,
                                            const Conversion& conversion, const CameraRecord& file);

}  // namespace alidade
