// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/error.h"

namespace alidade::detail {

/// What blanks separate: "fx fy" is the list fx, fy.
[[nodiscard]] std::vector<std::string> words(std::string_view text);

/// The line of a text, from 1, in which a place is.
[[nodiscard]] std::ptrdiff_t lineAt(std::string_view text, std::size_t offset);

/// Returns what `read` does. Its complaints, which do not know their place in a file, get `where`, and
/// become the file's fault. @throws Error (kInput)
template <class Read>
auto withPlace(const std::string& where, const Read& read) {
  try {
    return read();
  } catch (const Error& e) {
    throw inputError({.where = where, .found = e.what()});
  }
}

/// Texts of camera files get into YAML, JSON and HTML of ours, which others could not read with bytes that
/// are no UTF-8. `file` is only a name for messages.
/// @throws Error (kInput) with the line and the first such bytes, as \xNN
void checkUtf8(const std::string& text, const std::string& file);

/// The text with each byte that is no UTF-8 as \xNN: names of images may be any bytes, our files may not.
[[nodiscard]] std::string withBytesShown(const std::string& text);

}  // namespace alidade::detail
