// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace alidade {

/// Reads the whole of `text` as a number, in any locale. Accepts "nan" and "inf"; surrounding blanks are not
/// accepted.
[[nodiscard]] std::optional<double> parseDouble(std::string_view text);
[[nodiscard]] std::optional<int> parseInt(std::string_view text);

/// The shortest text that reads back as exactly the same number.
[[nodiscard]] std::string exactText(double value);

[[nodiscard]] std::string_view trim(std::string_view text);
[[nodiscard]] std::vector<std::string_view> split(std::string_view text, char separator);
[[nodiscard]] std::string join(std::span<const std::string> parts, std::string_view separator);

/// The candidate with the fewest edits from `name`, if it is close enough to be a typing error.
[[nodiscard]] std::optional<std::string> nearestName(std::string_view name,
                                                     std::span<const std::string> candidates);

/// "did you mean 'fx'?" if there is a candidate, for Error::next_step; otherwise `otherwise`.
[[nodiscard]] std::string didYouMean(std::string_view name, std::span<const std::string> candidates,
                                     std::string otherwise = "");

/// True if `a` comes before `b` as a person sorts file names: runs of digits compare by their value
/// (img2 before img10). A strict total order.
[[nodiscard]] bool naturalLess(std::string_view a, std::string_view b);

}  // namespace alidade
