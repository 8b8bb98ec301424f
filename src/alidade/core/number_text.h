// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <string>

namespace alidade {

/// A number as printf() writes it.
[[nodiscard]] inline std::string numberText(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace alidade
