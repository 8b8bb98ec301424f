// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/record/conversion.h"

namespace alidade {

/// What made a converted file: "alidade 0.1.0 convert crop 0,60,640,360, resize 320x180 of camera.yaml
/// (...)".
[[nodiscard]] std::string provenance(const std::string& path, const CameraRecord& source,
                                     const Conversion& conversion);

/// What was done and what came out, for people; without an end of line.
[[nodiscard]] std::string conversionSummary(const std::string& path, const CameraRecord& source,
                                            const Conversion& conversion, const CameraRecord& file);

/// The same for programs.
[[nodiscard]] nlohmann::json conversionJson(const std::string& path, const CameraRecord& source,
                                            const Conversion& conversion, const CameraRecord& file);

}  // namespace alidade
