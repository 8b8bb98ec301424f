// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace alidade::detail {

/// The fewest digits that read back as the same number, with a point before the exponent: readers of YAML 1.1
/// (Python's, and with it Kalibr and ROS) take 1e-05 for a text and 1 for a whole number.
[[nodiscard]] std::string realText(double value);

/// "[1.0, 0.25, -3.0e-05]": a list of these.
[[nodiscard]] std::string listText(std::span<const double> values);

/// A string as a YAML scalar, in quotation marks where it needs them.
[[nodiscard]] std::string yamlText(const std::string& text);

/// A JSON document as a file: indented, with an end of line. Doubles read back as the same.
[[nodiscard]] std::string jsonFileText(const nlohmann::ordered_json& document);

}  // namespace alidade::detail
