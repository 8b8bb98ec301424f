// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "alidade/core/error.h"

namespace alidade {

inline constexpr int kInputExit = static_cast<int>(ErrorCode::kInput);
inline constexpr std::string_view kOutOfMemory =
    "out of memory\n  next: use smaller or fewer images, or fewer --jobs";

/// Runs the command line, and reports errors. @returns the exit code. @throws Cancelled if a signal requested
/// the end
[[nodiscard]] int runProgram(int argc, char** argv);

}  // namespace alidade
