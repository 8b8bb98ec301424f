// SPDX-License-Identifier: MIT
#include "alidade/files/board_file.h"

#include <filesystem>

#include "alidade/files/yaml_node.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

Checkerboard boardFrom(const detail::YamlNode& root) {
  root.allowKeys({"kind", "columns", "rows", "square"});
  const detail::YamlNode kind = root.at("kind");
  if (kind.text() != "checkerboard") throw kind.error("'" + kind.text() + "'", "checkerboard");
  Checkerboard board;
  board.columns = root.at("columns").integer();
  board.rows = root.at("rows").integer();
  const detail::YamlNode square = root.at("square");
  try {
    board.square_m = parseLength(square.text(), square.where());
    checkBoard(board, square.where());
  } catch (const Error& e) {
    throw inputError({.where = e.what()});  // what a flag would get wrong is here a file's fault
  }
  return board;
}

}  // namespace

Checkerboard parseBoard(const std::string& text, const std::string& name) {
  return boardFrom(detail::YamlNode::parse(text, name));
}

Checkerboard readBoard(const std::string& source) {
  std::error_code ignored;  // what cannot be looked at is no file
  const bool is_file = source.ends_with(".yaml") || source.ends_with(".yml") ||
                       (source.find(':') == std::string::npos && std::filesystem::exists(source, ignored));
  if (!is_file) return parseBoardSpec(source);
  return boardFrom(detail::YamlNode::readFile(source));
}

}  // namespace alidade
