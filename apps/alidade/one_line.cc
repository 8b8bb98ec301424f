// SPDX-License-Identifier: MIT
#include "one_line.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

namespace alidade {
namespace {

// The bytes of the UTF-8 character at the start; 0: there is none.
std::size_t characterSize(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  const std::size_t size = first < 0x80   ? 1
                           : first < 0xc2 ? 0
                           : first < 0xe0 ? 2
                           : first < 0xf0 ? 3
                           : first < 0xf5 ? 4
                                          : 0;
  if (size == 0 || size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0U) != 0x80U) return 0;
  }
  // Overlong forms, surrogates, and code points that do not exist.
  if ((first == 0xe0 && byte(1) < 0xa0) || (first == 0xed && byte(1) > 0x9f)) return 0;
  if ((first == 0xf0 && byte(1) < 0x90) || (first == 0xf4 && byte(1) > 0x8f)) return 0;
  // The second set of control characters, and two code points that XML does not have.
  if (first == 0xc2 && byte(1) < 0xa0) return 0;
  if (first == 0xef && byte(1) == 0xbf && byte(2) >= 0xbe) return 0;
  return size;
}

}  // namespace

std::string oneLine(std::string text) {
  constexpr std::string_view kNextLine = "\n  next: ";
  for (std::size_t at = text.find(kNextLine); at != std::string::npos; at = text.find(kNextLine, at))
    text.replace(at, kNextLine.size(), "; next: ");
  for (char& c : text) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return text;
}

std::string printable(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const auto first = static_cast<unsigned char>(text.front());
    const bool is_control = first < 0x20 || first == 0x7f;
    const std::size_t size = is_control ? 0 : characterSize(text);
    if (size == 0) result += fmt::format("\\x{:02x}", first);
    result += text.substr(0, size);
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
  return result;
}

}  // namespace alidade
