// SPDX-License-Identifier: MIT
#include "alidade/core/aliases.h"

#include <algorithm>
#include <map>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// The names by all words that stand for them.
std::map<std::string, std::string> meanings(std::span<const AliasedName> names) {
  std::map<std::string, std::string> name_of;
  for (const AliasedName& name : names) {
    name_of.emplace(bareWord(name.name), name.name);
    for (const std::string_view alias : split(name.aliases, ' ')) name_of.emplace(bareWord(alias), name.name);
  }
  return name_of;
}

}  // namespace

std::string bareWord(std::string_view word) {
  std::string text;
  for (const char c : word) {
    if (c != '-' && c != '_') text += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return text.empty() ? std::string(word) : text;  // "-" is a word too
}

std::optional<std::string> meantName(std::string_view word, std::span<const AliasedName> names) {
  const auto name_of = meanings(names);
  const auto found = name_of.find(bareWord(word));
  return word.empty() || found == name_of.end() ? std::nullopt : std::optional(found->second);
}

std::string didYouMeanOne(std::string_view word, std::span<const AliasedName> names,
                          const std::string& otherwise) {
  const auto name_of = meanings(names);
  const auto nearest =
      nearestName(bareWord(word), mapped(name_of, [](const auto& entry) { return entry.first; }));
  return nearest ? "did you mean '" + name_of.at(*nearest) + "'?" : otherwise;
}

}  // namespace alidade
