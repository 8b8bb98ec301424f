// SPDX-License-Identifier: MIT
#include "alidade/files/board_file.h"

#include <algorithm>
#include <filesystem>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/text/file_text.h"
#include "alidade/files/text/yaml_node.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

// Built from the SPEC with the same parts, so no part may contain ':'.
Board boardFrom(const detail::YamlNode& root) {
  if (root.isMap() && !root.has("kind"))
    throw root.error("no key 'kind'", "a board file, with the keys kind, columns, rows and lengths",
                     "give a SPEC, for example checkerboard:9x6:25mm; see docs/boards.md");
  const detail::YamlNode kind = root.at("kind");
  const auto known = std::ranges::find(boardKinds(), boardKindOf(kind.text()), &BoardKindName::name);
  if (known == boardKinds().end())
    throw kind.error("'" + kind.text() + "'", join(mapped(boardKinds(), &BoardKindName::name), ", "));
  std::vector<std::string> keys = {"kind", "columns", "rows"};
  keys.insert(keys.end(), known->keys.begin(), known->keys.end());
  root.allowKeys(keys);
  std::string spec = known->name + ":" + std::to_string(root.at("columns").integer()) + "x" +
                     std::to_string(root.at("rows").integer());
  std::string where = root.at("rows").where();
  for (std::size_t i = 0; i < known->keys.size(); ++i) {
    if (i >= known->num_required && !root.find(known->keys[i])) continue;
    const detail::YamlNode part = root.at(known->keys[i]);
    if (part.text().find(':') != std::string::npos) throw part.error("'" + part.text() + "'", "no ':'");
    spec += ":" + part.text();
    where = part.where();
  }
  return detail::withPlace(where, [&] { return parseBoardSpec(spec); });
}

}  // namespace

Board readBoard(const std::string& source) {
  std::error_code ignored;  // a path that cannot be examined is not a file
  const bool is_file = source.ends_with(".yaml") || source.ends_with(".yml") ||
                       (source.find(':') == std::string::npos && std::filesystem::exists(source, ignored));
  if (!is_file) return parseBoardSpec(source);
  return boardFrom(detail::YamlNode::readFile(source));
}

}  // namespace alidade
