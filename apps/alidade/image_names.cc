// SPDX-License-Identifier: MIT
#include "image_names.h"

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

std::vector<std::string> shortNames(const std::vector<std::string>& paths) {
  const std::string& first = paths.front();
  std::size_t shared = first.rfind('/') == std::string::npos ? 0 : first.rfind('/') + 1;
  for (const std::string& path : paths) {
    while (shared > 0 && path.compare(0, shared, first, 0, shared) != 0) {
      const std::size_t slash = shared < 2 ? std::string::npos : first.rfind('/', shared - 2);
      shared = slash == std::string::npos ? 0 : slash + 1;
    }
  }
  std::vector<std::string> names;
  for (const std::string& path : paths) names.push_back(path.substr(shared));
  return names;
}

}  // namespace alidade
