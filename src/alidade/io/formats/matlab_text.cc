// SPDX-License-Identifier: MIT
#include "alidade/io/formats/matlab_text.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>

#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

struct Property {
  std::string_view key;
  std::string_view value;
};

bool isNameCharacter(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

// "  FocalLength: [714.19 710.38]"; nothing for headings and text.
std::optional<Property> propertyOf(std::string_view line) {
  line = trim(line);
  const std::size_t colon = line.find(": ");
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  const std::string_view key = line.substr(0, colon);
  if (!std::all_of(key.begin(), key.end(), isNameCharacter)) return std::nullopt;
  return Property{.key = key, .value = trim(line.substr(colon + 2))};
}

// "[714.19, 710.38]" of "[714.19 710.38]"; nothing for "[3x3 double]" and what is no list.
std::optional<std::string> listOf(std::string_view value) {
  if (value.size() < 2 || value.front() != '[' || value.back() != ']') return std::nullopt;
  std::string list = "[";
  std::string number;
  const auto take = [&] {
    if (number.empty()) return true;
    if (!parseDouble(number)) return false;
    list += (list.size() > 1 ? ", " : "") + number;
    number.clear();
    return true;
  };
  for (const char c : value.substr(1, value.size() - 2)) {
    if (c != ' ' && c != ',' && c != '\t') {
      number += c;
    } else if (!take()) {
      return std::nullopt;
    }
  }
  if (!take()) return std::nullopt;
  return list + "]";
}

std::string quoted(std::string_view value) {
  std::string text = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') text += '\\';
    text += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return text + '"';
}

}  // namespace

bool isMatlabText(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos || text[first] == '{' || text[first] == '<') return false;
  for (const std::string_view line : split(text, '\n')) {
    const auto property = propertyOf(line);
    if (property && property->key == "FocalLength" && property->value.starts_with('[')) return true;
  }
  return false;
}

std::string matlabTextAsYaml(const std::string& text) {
  std::string yaml;
  for (const std::string_view line : split(text, '\n')) {
    if (const auto property = propertyOf(line)) {
      yaml += std::string(property->key) + ": ";
      yaml += listOf(property->value).value_or(quoted(property->value));
    }
    yaml += '\n';
  }
  return yaml;
}

}  // namespace alidade::detail
