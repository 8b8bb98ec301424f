// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade {

/// The text for a JSON document: bytes that are not UTF-8, which file names may contain, become U+FFFD.
[[nodiscard]] std::string validUtf8(const std::string& text);

}  // namespace alidade
