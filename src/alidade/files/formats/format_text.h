// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

namespace alidade::detail {

/// The fewest digits that read back as the same number, with a point before the exponent: readers of YAML 1.1
/// (Python's, and with it Kalibr and ROS) take 1e-05 for a text and 1 for a whole number.
[[nodiscard]] std::string realText(double value);

/// "[1.0, 0.25, -3.0e-05]": a list of these.
[[nodiscard]] std::string listText(std::span<const double> values);

/// A string as a YAML scalar, in quotation marks where it needs them.
[[nodiscard]] std::string yamlText(const std::string& text);

}  // namespace alidade::detail
