// SPDX-License-Identifier: MIT
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "alidade/core/text.h"
#include "apps/command_line.h"

namespace alidade {

/// Projects `points` through the camera of testdata/, with `more` arguments.
inline RunResult project(const std::string& points, std::vector<std::string> more = {}) {
  std::vector<std::string> args = {"project", dataPath("camera.yaml")};
  args.insert(args.end(), more.begin(), more.end());
  return runAlidade(args, {.input = points});
}

/// The rows of a table behind its header, cut into fields.
inline std::vector<std::vector<std::string>> rowsOf(const std::string& table) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(table);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    rows.emplace_back();
    for (const std::string_view field : split(line, ',')) rows.back().emplace_back(field);
  }
  return rows;
}

inline std::string headerOf(const std::string& table) {
  return table.substr(0, table.find('\n'));
}

inline double numberIn(const std::string& field) {
  const auto value = parseDouble(field);
  EXPECT_TRUE(value) << field;
  return value.value_or(0);
}

}  // namespace alidade
