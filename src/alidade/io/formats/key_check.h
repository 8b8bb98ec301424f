// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade::detail {

/// Refuses a YAML (or JSON) text with a key twice in one map, of which a reader would take either, and one
/// with more keys in a map than any camera file has. Linear in the text, aliases and all. `file` is only a
/// name for messages. @throws Error (kInput) with the line; YAML::Exception where the text is not YAML
void checkKeys(const std::string& text, const std::string& file);

}  // namespace alidade::detail
