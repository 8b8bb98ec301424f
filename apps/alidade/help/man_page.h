// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "help/command_text.h"

namespace alidade {

/// The name of a command's man page: "alidade-rig-calibrate".
[[nodiscard]] std::string manPageName(const CommandText& command);

/// The man page of a command in roff, for section 1. It contains the version and no date, so that two builds
/// give the same bytes. @param program  of which `command` is a part
[[nodiscard]] std::string manPage(const CommandText& command, const CommandText& program);

}  // namespace alidade
