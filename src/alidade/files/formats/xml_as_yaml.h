// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade::detail {

/// OpenCV's XML (root <opencv_storage>) as YAML of the same tree, in which every value stands in the line
/// that it has in `text`: messages can name it. Elements that hold no element are strings, or lists where
/// blanks separate several values; elements named "_" are the items of a list. `file` is only a name for
/// messages.
/// @throws Error (kInput) where the text is not XML, or not OpenCV's
[[nodiscard]] std::string xmlAsYaml(const std::string& text, const std::string& file);

}  // namespace alidade::detail
