// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string_view>

#include "alidade/target/board_field.h"

// What several kinds of boards cannot be.

namespace alidade::detail {

/// @param what  that is counted
[[nodiscard]] std::optional<BoardFault> countsFault(int columns, int rows, int least, int most,
                                                    std::string_view what);

/// @param what  in the plural
[[nodiscard]] std::optional<BoardFault> sideFault(double side_m, std::string_view what);

}  // namespace alidade::detail
