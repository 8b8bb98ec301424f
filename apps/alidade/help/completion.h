// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "help/command_text.h"

namespace alidade {

/// What bash, zsh and fish read to complete the commands, flags and values of the program. Each is the whole
/// text of a file: bash-completion/completions/alidade, zsh/vendor-completions/_alidade,
/// fish/vendor_completions.d/alidade.fish.
[[nodiscard]] std::string bashCompletion(const CommandText& program);
[[nodiscard]] std::string zshCompletion(const CommandText& program);
[[nodiscard]] std::string fishCompletion(const CommandText& program);

}  // namespace alidade
