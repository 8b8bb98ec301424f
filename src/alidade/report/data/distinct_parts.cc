// SPDX-License-Identifier: MIT
#include "alidade/report/data/distinct_parts.h"

#include <algorithm>

namespace alidade {
namespace {

// ".png" if all names end with it; otherwise empty.
std::string sharedExtension(const std::vector<std::string>& names) {
  if (names.empty()) return "";
  const std::size_t dot = names.front().rfind('.');
  if (dot == std::string::npos) return "";
  const std::string extension = names.front().substr(dot);
  const bool is_shared =
      std::ranges::all_of(names, [&](const std::string& name) { return name.ends_with(extension); });
  return is_shared ? extension : "";
}

}  // namespace

std::size_t sharedPrefix(const std::vector<std::string>& names) {
  if (names.size() < 2) return 0;
  const std::string& name = names.front();
  std::size_t length = name.size();
  for (const std::string& other : names) {
    const auto differs = std::ranges::mismatch(other, name);
    length = std::min(length, static_cast<std::size_t>(differs.in1 - other.begin()));
  }
  const auto isWithin = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; };
  const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
  while (length > 0 && length < name.size() && (isWithin(name[length]) || isDigit(name[length - 1])))
    --length;
  return length;
}

std::vector<std::string> distinctParts(const std::vector<std::string>& names) {
  const std::size_t prefix = sharedPrefix(names);
  const std::size_t extension = sharedExtension(names).size();
  const bool is_any_empty =
      std::ranges::any_of(names, [&](const std::string& name) { return name.size() <= prefix + extension; });
  if (is_any_empty) return names;
  std::vector<std::string> parts;
  for (const std::string& name : names)
    parts.push_back(name.substr(prefix, name.size() - prefix - extension));
  return parts;
}

}  // namespace alidade
