// SPDX-License-Identifier: MIT
#include "alidade/files/settings_file.h"

#include "alidade/files/text/yaml_node.h"

namespace alidade {

std::vector<SettingEntry> readSettingsFile(const std::string& path) {
  const detail::YamlNode root = detail::YamlNode::readFile(path);
  if (!root.isMap())
    throw root.error("no map", "a map with flags as keys, for example\n  board: checkerboard:9x6:25mm");
  std::vector<SettingEntry> entries;
  for (const std::string& key : root.keys()) {
    if (detail::isUserKey(key)) continue;
    const detail::YamlNode value = root.at(key);
    entries.push_back({.key = key, .values = value.texts(), .where = value.where()});
  }
  return entries;
}

}  // namespace alidade
