// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace alidade {

/// An error's message, which has a line of its own for the next step, in a single line.
[[nodiscard]] std::string oneLine(std::string text);

/// `text` with control characters and bytes that are not UTF-8 as "\x1b". File names may contain both: they
/// would change the terminal, forge a line of a table, or make XML invalid.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace alidade
