// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade::detail {

/// Writes a text, a number, a list of these in brackets, or the output of a function of the emitter. Numbers
/// are written as text in their shortest exact form; the emitter's own 17 digits would turn 0.1 into
/// 0.10000000000000001. A missing number is written as null.
template <class T>
void writeValue(YAML::Emitter& out, const T& value) {
  if constexpr (std::is_same_v<T, std::optional<double>>) {
    if (value) return writeValue(out, *value);
    out << YAML::Null;
  } else if constexpr (std::is_same_v<T, double>) {
    expect(std::isfinite(value), "only finite numbers are written to a file");
    out << exactText(value);
  } else if constexpr (std::is_convertible_v<const T&, std::string_view>) {
    out << std::string(std::string_view(value));
  } else if constexpr (std::is_integral_v<T>) {
    out << value;
  } else if constexpr (requires { value.begin(); }) {
    out << YAML::Flow << YAML::BeginSeq;
    for (const auto& item : value) writeValue(out, item);
    out << YAML::EndSeq;
  } else {
    value(out);
  }
}

/// Entries of a map that is open: key, value, key, value.
template <class T, class... Rest>
void writeEntries(YAML::Emitter& out, std::string_view key, const T& value, const Rest&... rest) {
  out << YAML::Key << std::string(key) << YAML::Value;
  writeValue(out, value);
  if constexpr (sizeof...(rest) > 0) writeEntries(out, rest...);
}

/// A value {key: value, key: value}. @pre the values live until it is written
template <class... Entries>
[[nodiscard]] auto flowMap(const Entries&... entries) {
  return [entries = std::tie(entries...)](YAML::Emitter& out) {
    out << YAML::Flow << YAML::BeginMap;
    std::apply([&out](const auto&... e) { writeEntries(out, e...); }, entries);
    out << YAML::EndMap;
  };
}

/// Text of the user, in quotes: a serial number must not become a number. @pre it lives until it is written
[[nodiscard]] inline auto quoted(const std::string& text) {
  return [&text](YAML::Emitter& out) { out << YAML::DoubleQuoted << text; };
}

/// A list of the values that `valueOf` makes of the items, one item per line.
template <class Items, class ValueOf>
[[nodiscard]] auto listOf(const Items& items, const ValueOf& valueOf) {
  return [&items, valueOf](YAML::Emitter& out) {
    out << YAML::BeginSeq;
    for (const auto& item : items) valueOf(out, item);
    out << YAML::EndSeq;
  };
}

/// A lower triangle, one row per line. @pre `triangle` has n (n + 1) / 2 numbers and lives until it
/// is written
[[nodiscard]] inline auto triangleRows(const std::vector<double>& triangle) {
  return [&triangle](YAML::Emitter& out) {
    out << YAML::BeginSeq;
    for (auto [at, size] = std::pair(triangle.begin(), std::ptrdiff_t{1}); at != triangle.end(); at += size++)
      writeValue(out, std::span(at, at + size));
    out << YAML::EndSeq;
  };
}

/// The text of a document, which must be closed.
[[nodiscard]] inline std::string documentText(const YAML::Emitter& out) {
  return std::string(out.c_str(), out.size()) + "\n";
}

}  // namespace alidade::detail
