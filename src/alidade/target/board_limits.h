// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string_view>

#include "alidade/target/board_field.h"

// Limits that several kinds of boards share.

namespace alidade::detail {

/// @param what  name of the counted parts
[[nodiscard]] std::optional<BoardFault> countsFault(int columns, int rows, int least, int most,
                                                    std::string_view what);

/// @param what  name of the sides, in the plural
[[nodiscard]] std::optional<BoardFault> sideFault(double side_m, std::string_view what);

}  // namespace alidade::detail
