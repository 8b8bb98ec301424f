// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/error.h"

namespace alidade::detail {

/// Splits text at blanks: "fx fy" is the list fx, fy.
[[nodiscard]] std::vector<std::string> words(std::string_view text);

/// The line number, from 1, of a position in a text.
[[nodiscard]] std::ptrdiff_t lineAt(std::string_view text, std::size_t offset);

/// Returns the result of `read`. Its errors, which do not know their place in a file, get `where` and become
/// input errors. @throws Error (kInput)
template <class Read>
auto withPlace(const std::string& where, const Read& read) {
  try {
    return read();
  } catch (const Error& e) {
    throw inputError({.where = where, .found = e.what()});
  }
}

/// Rejects text that is not UTF-8: texts of camera files are copied into YAML, JSON and HTML, which would
/// become unreadable. `file` is only a name for messages.
/// @throws Error (kInput) with the line and the first such bytes, as \xNN
void checkUtf8(const std::string& text, const std::string& file);

/// The text with each invalid UTF-8 byte as \xNN: names of images may be any bytes, our files may not.
[[nodiscard]] std::string withBytesShown(const std::string& text);

}  // namespace alidade::detail
