// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade {

/// The text as a JSON document has it: bytes that are not UTF-8, which names of files may contain, become
/// U+FFFD.
[[nodiscard]] std::string validUtf8(const std::string& text);

}  // namespace alidade
