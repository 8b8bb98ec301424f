// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/target/board.h"

namespace alidade {

/// The board of a --board argument: a SPEC such as checkerboard:9x6:25mm, or a YAML file with the keys kind
/// (checkerboard), columns, rows (inner corners) and square (a length such as 25mm).
/// @throws Error (kUsage for a SPEC, kInput for a file)
[[nodiscard]] Board readBoard(const std::string& spec_or_path);

}  // namespace alidade
