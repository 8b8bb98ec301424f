// SPDX-License-Identifier: MIT
#include "number_check.h"

#include <cmath>

#include <fmt/format.h>

#include "alidade/core/text.h"

namespace alidade {
namespace {

std::string complaint(const std::string& found, const std::string& expected) {
  return fmt::format("found '{}', expected {}", found, expected);
}

}  // namespace

NumberCheck positiveNumber() {
  return [](const std::string& text) {
    const auto value = parseDouble(text);
    const bool is_good = value && std::isfinite(*value) && *value > 0;
    return is_good ? std::string() : complaint(text, "a finite number above 0");
  };
}

NumberCheck nonNegativeNumber() {
  return [](const std::string& text) {
    const auto value = parseDouble(text);
    const bool is_good = value && std::isfinite(*value) && *value >= 0;
    return is_good ? std::string() : complaint(text, "a finite number, 0 or more");
  };
}

NumberCheck wholeNumber(int least, int most) {
  return [least, most](const std::string& text) {
    const auto value = parseInt(text);
    const bool is_good = value && *value >= least && *value <= most;
    return is_good ? std::string()
                   : complaint(text, fmt::format("a whole number from {} to {}", least, most));
  };
}

}  // namespace alidade
