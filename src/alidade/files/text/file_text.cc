// SPDX-License-Identifier: MIT
#include "alidade/files/text/file_text.h"

#include <algorithm>
#include <iterator>
#include <sstream>

namespace alidade::detail {
namespace {

unsigned byteAt(std::string_view text, std::size_t at) {
  return static_cast<unsigned char>(text[at]);
}

// The number of bytes of the character at `at`; 0 if it is invalid. The Unicode standard's table 3-7: no
// overlong forms, no surrogates, nothing beyond U+10FFFF.
std::size_t lengthOfCharacter(std::string_view text, std::size_t at) {
  const unsigned first = byteAt(text, at);
  if (first < 0x80U) return 1;
  const std::size_t length = first >= 0xF0U ? 4 : (first >= 0xE0U ? 3 : 2);
  if (first < 0xC2U || first > 0xF4U || text.size() - at < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byteAt(text, at + i) & 0xC0U) != 0x80U) return 0;
  }
  const unsigned second = byteAt(text, at + 1);
  const bool is_allowed = (first != 0xE0U || second >= 0xA0U) && (first != 0xEDU || second < 0xA0U) &&
                          (first != 0xF0U || second >= 0x90U) && (first != 0xF4U || second < 0x90U);
  return is_allowed ? length : 0;
}

std::string shownByte(unsigned byte) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  return {'\\', 'x', kDigits[byte / 16], kDigits[byte % 16]};
}

// "K\xF6ln": the text around the byte in its line, to find it in an editor.
std::string shown(std::string_view text, std::size_t at) {
  constexpr std::size_t kBefore = 24;
  constexpr std::size_t kAfter = 8;
  const std::size_t line = text.rfind('\n', at) + 1;  // npos + 1 = 0
  const std::size_t from = std::max(line, at - std::min(at, kBefore));
  const std::size_t end = std::min(text.find_first_of("\r\n", at), at + kAfter);
  std::string out;
  for (const char c : text.substr(from, end - from)) {
    const bool is_ascii = c >= ' ' && c < 0x7F;
    out += is_ascii ? std::string(1, c) : shownByte(static_cast<unsigned char>(c));
  }
  return out;
}

}  // namespace

std::vector<std::string> words(std::string_view text) {
  std::istringstream stream{std::string(text)};
  return {std::istream_iterator<std::string>(stream), std::istream_iterator<std::string>()};
}

std::ptrdiff_t lineAt(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  return 1 + std::count(before.begin(), before.end(), '\n');
}

void checkUtf8(const std::string& text, const std::string& file) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = lengthOfCharacter(text, at);
    if (length == 0) {
      throw inputError({.where = file + ":" + std::to_string(lineAt(text, at)),
                        .found = "found bytes that are not UTF-8: \"" + shown(text, at) + "\"",
                        .expected = "text in UTF-8",
                        .next_step = "save the file as UTF-8, or replace these characters with ASCII"});
    }
    at += length;
  }
}

std::string withBytesShown(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = lengthOfCharacter(text, at);
    out += length == 0 ? shownByte(byteAt(text, at)) : text.substr(at, length);
    at += std::max<std::size_t>(length, 1);
  }
  return out;
}

}  // namespace alidade::detail
