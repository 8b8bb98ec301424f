// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade::detail {

/// Is this what MATLAB's command window prints of a camera: a line "FocalLength: [714.19 710.38]"?
[[nodiscard]] bool isMatlabText(const std::string& text);

/// The properties of such a text as YAML, each in its own line: numbers as lists, anything else as a string.
[[nodiscard]] std::string matlabTextAsYaml(const std::string& text);

}  // namespace alidade::detail
