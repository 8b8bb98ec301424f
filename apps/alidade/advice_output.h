// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/core/image.h"
#include "alidade/guide/coverage.h"
#include "alidade/guide/guidance.h"

namespace alidade {

/// What a calibration tells about the photographs: those that were taken, and the next one.
struct Advice {
  CoverageReport coverage;
  Guidance guidance;
};

/// Lines of the summary.
[[nodiscard]] std::string adviceText(const Advice& advice, ImageSize size);

/// Adds the keys `coverage`, `next_view` and `target` to a document.
void addAdvice(const Advice& advice, nlohmann::json& document);

/// A number of pixels: "0.1px", "0.1 px" or "0.1". `where` names the place for the message.
/// @throws Error (kUsage) if it is none, or not positive
[[nodiscard]] double parsePixels(const std::string& text, const std::string& where);

}  // namespace alidade
