// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

namespace alidade {

/// Checks of a flag's number, for CLI::Option::check(): what is wrong with the text, or nothing. The parser's
/// own name their limits as numbers, and that of a double has 300 digits.
using NumberCheck = std::function<std::string(const std::string&)>;

/// Above 0 and finite.
[[nodiscard]] NumberCheck positiveNumber();

/// 0 or above, and finite.
[[nodiscard]] NumberCheck nonNegativeNumber();

/// A whole number from `least` to `most`.
[[nodiscard]] NumberCheck wholeNumber(int least, int most);

}  // namespace alidade
