// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace alidade {

/// A name and the words of other programs for the same thing, separated by blanks.
struct AliasedName {
  std::string name;
  std::string_view aliases = {};
};

/// A word in lower case, without the hyphens and underscores that programs put in it.
[[nodiscard]] std::string bareWord(std::string_view word);

/// The name that a word stands for: the name itself or one of its aliases, in any case, with or without
/// hyphens and underscores.
[[nodiscard]] std::optional<std::string> meantName(std::string_view word, std::span<const AliasedName> names);

/// "did you mean 'radtan'?" for a word that stands for a name or resembles one, for Error::next_step;
/// otherwise `otherwise`.
[[nodiscard]] std::string didYouMeanOne(std::string_view word, std::span<const AliasedName> names,
                                        const std::string& otherwise = "");

}  // namespace alidade
