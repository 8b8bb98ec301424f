// SPDX-License-Identifier: MIT
#include "alidade/files/settings_file.h"

#include "alidade/files/user_keys.h"
#include "alidade/files/yaml_node.h"

namespace alidade {
namespace {

std::vector<SettingEntry> settingsFrom(const detail::YamlNode& root) {
  if (!root.isMap())
    throw root.error("no map", "a map with flags as keys, for example\n  board: checkerboard:9x6:25mm");
  root.allowKeys(root.keys());  // a doubled key
  std::vector<SettingEntry> entries;
  for (const std::string& key : root.keys()) {
    if (detail::isUserKey(key)) continue;
    const detail::YamlNode value = root.at(key);
    SettingEntry entry{.key = key, .values = {}, .where = value.where()};
    if (value.isSequence()) {
      for (const detail::YamlNode& item : value.items()) entry.values.push_back(item.text());
    } else {
      entry.values.push_back(value.text());
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace

std::vector<SettingEntry> readSettingsFile(const std::string& path) {
  return settingsFrom(detail::YamlNode::readFile(path));
}

std::vector<SettingEntry> parseSettings(const std::string& text, const std::string& name) {
  return settingsFrom(detail::YamlNode::parse(text, name));
}

}  // namespace alidade
