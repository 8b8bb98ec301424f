// SPDX-License-Identifier: MIT
#include "alidade/files/formats/matlab_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>
#include <vector>

#include "alidade/core/text.h"
#include "alidade/files/formats/stated_camera.h"

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

// The properties of a text, with the number of their lines from 1.
struct PlacedProperty {
  Property property;
  std::size_t line = 0;
};

std::vector<PlacedProperty> propertiesOf(const std::string& text) {
  std::vector<PlacedProperty> all;
  std::size_t number = 0;
  for (const std::string_view line : split(text, '\n')) {
    ++number;
    if (const auto property = propertyOf(line)) all.push_back({*property, number});
  }
  return all;
}

bool isFocalLength(const PlacedProperty& placed) {
  return placed.property.key == "FocalLength" && placed.property.value.starts_with('[');
}

// What holds the numbers of a camera, or the properties of one.
bool holdsCamera(const PlacedProperty& placed) {
  constexpr std::array kHolders = {"Intrinsics", "K", "IntrinsicMatrix", "CameraParameters1",
                                   "CameraParameters2"};
  return std::find(kHolders.begin(), kHolders.end(), placed.property.key) != kHolders.end() &&
         isUnexpanded(placed.property.value);
}

// Three numbers with blanks between them.
bool isRowOfMatrix(std::string_view line) {
  std::size_t count = 0;
  for (const std::string_view word : split(trim(line), ' ')) {
    if (word.empty()) continue;
    if (!parseDouble(word) || ++count > 3) return false;
  }
  return count == 3;
}

// "K =", a blank line, perhaps "1.0e+03 *", and three rows: its line from 1; 0 if there is none.
std::size_t lineOfPrintedMatrix(const std::string& text) {
  std::size_t number = 0;
  std::size_t start = 0;
  std::size_t num_rows = 0;
  for (const std::string_view whole : split(text, '\n')) {
    ++number;
    const std::string_view line = trim(whole);
    if (line.empty() || (start > 0 && line.ends_with('*'))) continue;
    if (line.ends_with('=')) {
      start = number;
      num_rows = 0;
    } else if (start > 0 && isRowOfMatrix(line)) {
      if (++num_rows == 3) return start;
    } else {
      start = 0;
    }
  }
  return 0;
}

}  // namespace

bool isPrintedMatrix(const std::string& text) {
  return lineOfPrintedMatrix(text) > 0;
}

bool isUnexpanded(std::string_view value) {
  if (!value.starts_with('[') || !value.ends_with(']')) return false;
  const auto digits = [&value] {
    const std::size_t end = std::min(value.find_first_not_of("0123456789"), value.size());
    value.remove_prefix(end);
    return end > 0;
  };
  value.remove_prefix(1);
  if (!digits()) return false;
  for (const std::string_view times : {"x", "\u00D7"}) {
    if (!value.starts_with(times)) continue;
    value.remove_prefix(times.size());
    return digits() && value.starts_with(' ');
  }
  return false;
}

bool isMatlabText(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos || text[first] == '{' || text[first] == '<') return false;
  const std::vector<PlacedProperty> all = propertiesOf(text);
  return std::any_of(all.begin(), all.end(), [](const PlacedProperty& placed) {
    return isFocalLength(placed) || holdsCamera(placed);
  });
}

void refuseUnexpanded(const std::string& text, const std::string& file) {
  const std::vector<PlacedProperty> all = propertiesOf(text);
  if (std::any_of(all.begin(), all.end(), isFocalLength)) return;
  const auto holder = std::find_if(all.begin(), all.end(), holdsCamera);
  if (holder == all.end()) return;
  const std::string key(holder->property.key);
  const std::string place = file + ":" + std::to_string(holder->line) + ": " + key;
  if (holder->property.value.find("fisheye") != std::string_view::npos) {
    throw UnsupportedCamera(inputError(
        {.where = place,
         .found = "found a fisheye by Scaramuzza's polynomial",
         .expected = "cameraIntrinsics or cameraParameters",
         .next_step = "calibrate the images with this program: alidade calibrate --model kannala_brandt"}));
  }
  // A matrix is printed over several lines, which are not read.
  const bool is_matrix = key == "K" || key == "IntrinsicMatrix";
  const std::string member = key == "Intrinsics" ? key : key + ".Intrinsics";
  const std::string printed = is_matrix ? "" : ", or print params." + member + " after format long";
  throw inputError({.where = place,
                    .found = "found " + std::string(holder->property.value) +
                             ", which the command window printed instead of the numbers",
                    .expected = "FocalLength and PrincipalPoint with their numbers",
                    .next_step = "export the object as JSON, jsonencode(toStruct(params))" + printed});
}

void refusePrintedMatrix(const std::string& text, const std::string& file) {
  const std::size_t line = lineOfPrintedMatrix(text);
  if (line == 0) return;
  throw inputError({.where = file + ":" + std::to_string(line),
                    .found =
                        "found a matrix as the command window prints it, which says neither the distortion "
                        "nor the size of the image",
                    .expected = "FocalLength and PrincipalPoint with their numbers",
                    .next_step = "export the object as JSON, jsonencode(toStruct(params)), or print "
                                 "params.Intrinsics after format long"});
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
