// SPDX-License-Identifier: MIT
#include "alidade/core/error_text.h"

#include <cstddef>
#include <string_view>

namespace alidade {

std::string oneLine(std::string text) {
  constexpr std::string_view kNextLine = "\n  next: ";
  for (std::size_t at = text.find(kNextLine); at != std::string::npos; at = text.find(kNextLine, at))
    text.replace(at, kNextLine.size(), "; next: ");
  for (char& c : text) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return text;
}

}  // namespace alidade
