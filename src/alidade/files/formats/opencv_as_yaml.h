// SPDX-License-Identifier: MIT
#pragma once

#include <string>

// Files of cv::FileStorage as YAML proper, in which every value stands in the line that it has in `text`.
namespace alidade::detail {

/// OpenCV's YAML, which starts with %YAML:1.0 and whose parser (modules/core/src/persistence_yml.cpp) ends a
/// key at the colon, whatever comes next. That first line becomes a comment, and where a value stands right
/// behind its key's colon ("data:[1, 2]") and YAML wants a blank between the two, there is one. That goes for
/// keys at the start of a line, perhaps indented, alone: one further along its line, as within { }, still
/// needs its blank. Linear in the text.
[[nodiscard]] std::string openCvAsYaml(const std::string& text);

/// OpenCV's XML (root <opencv_storage>). Elements that hold no element are strings, or lists where blanks
/// separate several values; elements named "_" are the items of a list. `file` is only a name for messages.
/// @throws Error (kInput) where the text is not XML, or not OpenCV's
[[nodiscard]] std::string openCvXmlAsYaml(const std::string& text, const std::string& file);

}  // namespace alidade::detail
