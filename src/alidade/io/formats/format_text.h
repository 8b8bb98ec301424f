// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

namespace alidade::detail {

/// "[1, 0.25, -3e-05]": each number in the fewest digits that read back as the same.
[[nodiscard]] std::string listText(std::span<const double> values);

/// exactText with a point or an exponent: some readers take a number without for a whole number.
[[nodiscard]] std::string realText(double value);

/// A string as a YAML scalar, in quotation marks where it needs them.
[[nodiscard]] std::string yamlText(const std::string& text);

}  // namespace alidade::detail
