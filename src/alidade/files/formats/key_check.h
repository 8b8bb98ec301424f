// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/files/yaml_node.h"

namespace alidade::detail {

/// Parses a YAML (or JSON) text. Refuses one with a key twice in one map, of which a reader would take
/// either, and one with more keys in a map than any camera file has; that costs no pass over the text of its
/// own, and is linear in it, aliases and all. `file` is only a name for messages. @throws Error (kInput) with
/// the line
[[nodiscard]] YamlNode parseWithUniqueKeys(const std::string& text, const std::string& file);

}  // namespace alidade::detail
