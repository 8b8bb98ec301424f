// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade::detail {

/// Does the text start as YAML of OpenCV's FileStorage does, with %YAML:1.0?
[[nodiscard]] bool isOpenCvYaml(const std::string& text);

/// The same as YAML proper, for a text of which isOpenCvYaml holds: that line is a comment, and where OpenCV
/// takes a value right behind its key's colon ("data:[1, 2]") and YAML wants a blank between the two, there
/// is one. That goes for keys at the start of a line, perhaps indented, alone: one further along its line, as
/// within { }, still needs its blank. Linear in the text. Lines stay as they are, and so do quoted texts and
/// comments.
[[nodiscard]] std::string openCvAsYaml(const std::string& text);

}  // namespace alidade::detail
