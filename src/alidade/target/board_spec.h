// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "alidade/target/checkerboard.h"

namespace alidade {

/// Reads a board SPEC such as "checkerboard:9x6:25mm": columns x rows of inner corners, then the side of a
/// square. Lengths carry a unit (mm, cm, m, in); a bare number is metres.
/// @throws Error (kUsage) saying which part is wrong, with an example that works.
[[nodiscard]] Checkerboard parseBoardSpec(std::string_view spec);

/// Reads a length with its unit, in metres. `where` names the place for the message.
/// @throws Error (kUsage)
[[nodiscard]] double parseLength(std::string_view text, const std::string& where);

/// Checks counts and square size against what a real board can be. `where` names the place for the message.
/// @throws Error (kUsage), for example when 25 mm was written as 25 (metres).
void checkBoard(const Checkerboard& board, const std::string& where);

}  // namespace alidade
