// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace alidade {

/// One key of a settings file: a flag's long name without dashes, and its value or values.
struct SettingEntry {
  std::string key;
  std::vector<std::string> values;
  std::string where;  ///< file, line and key, for messages
};

/// Reads a YAML map of flags, as --config takes it: each value a scalar or a list of scalars. Keys that start
/// with x_ are ignored. The caller checks which keys exist.
/// @throws Error (kInput)
[[nodiscard]] std::vector<SettingEntry> readSettingsFile(const std::string& path);

}  // namespace alidade
