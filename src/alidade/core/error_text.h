// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace alidade {

/// The message of an Error, whose next step is a separate line, in a single line.
[[nodiscard]] std::string oneLine(std::string text);

}  // namespace alidade
