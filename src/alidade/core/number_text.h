// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdio>
#include <string>
#include <string_view>

namespace alidade {

/// A number as printf() writes it; "110" instead of "1.1e+02".
[[nodiscard]] inline std::string numberText(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  const std::string written = text;
  constexpr double kLong = 1e7;  // longer numbers keep their exponent
  if (written.find("e+") == std::string::npos || !(std::abs(value) < kLong)) return written;
  std::snprintf(text, sizeof text, "%.0f", std::stod(written));
  return text;
}

/// A share in percent, without decimals: "81 %". Only exactly 1 and 0 give "100 %" and "0 %"; close values
/// give "> 99 %" and "< 1 %".
[[nodiscard]] inline std::string percentText(double share) {
  const double percent = 100 * share;
  if (percent > 0 && percent < 1) return "< 1 %";
  if (percent > 99 && percent < 100) return "> 99 %";
  return numberText("%.0f", std::clamp(percent, 0.0, 100.0)) + " %";
}

/// "1 view", "3 views".
[[nodiscard]] std::string counted(std::integral auto count, std::string_view noun) {
  return std::to_string(count).append(" ").append(noun).append(count == 1 ? "" : "s");
}

}  // namespace alidade
