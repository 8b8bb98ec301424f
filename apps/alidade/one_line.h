// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade {

/// An error's message, which has a line of its own for the next step, in a single line.
[[nodiscard]] std::string oneLine(std::string text);

}  // namespace alidade
