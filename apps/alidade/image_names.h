// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace alidade {

/// Names as short as they can be while telling the images apart: paths without the folders that all share.
[[nodiscard]] std::vector<std::string> shortNames(const std::vector<std::string>& paths);

/// An error's message, which has a line of its own for the next step, in a single line.
[[nodiscard]] std::string oneLine(std::string text);

}  // namespace alidade
