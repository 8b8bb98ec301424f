// SPDX-License-Identifier: MIT
#include "alidade/files/frame_table_file.h"

#include <set>
#include <string_view>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/file_text.h"
#include "alidade/files/text/table_lines.h"

namespace alidade {

FrameTable readFrameTable(const std::string& path) {
  constexpr std::size_t kMaxBytes = std::size_t{64} << 20U;
  const std::string text = readTextFile(path, kMaxBytes);
  FrameTable table;
  table.path = path;
  std::size_t number = 0;
  for (std::string_view line : split(text, '\n')) {
    ++number;
    line = trim(line);
    if (line.empty() || line.front() == '#') continue;
    const std::string where = path + ":" + std::to_string(number);
    auto fields = detail::splitCsv(line);
    if (!fields) throw detail::errorAt(where, "a quote that is not closed");
    for (std::string& field : *fields) field = std::string(trim(field));
    if (table.cameras.empty()) {
      const std::set<std::string> unique(fields->begin(), fields->end());
      if (fields->size() < 2 || unique.size() != fields->size() || unique.contains("")) {
        throw detail::errorAt(where, "the header '" + std::string(line) + "'",
                              "the names of two or more cameras, separated by commas");
      }
      table.cameras = std::move(*fields);
      continue;
    }
    if (fields->size() != table.cameras.size()) {
      throw detail::errorAt(where, std::to_string(fields->size()) + " fields",
                            std::to_string(table.cameras.size()) + ", one for each camera");
    }
    table.rows.push_back(std::move(*fields));
    table.lines.push_back(number);
  }
  if (table.rows.empty()) {
    throw detail::errorAt(path, "no frame", "a header with the cameras' names, and a row for each frame");
  }
  return table;
}

}  // namespace alidade
