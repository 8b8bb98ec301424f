// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace alidade {

/// Completions of the last of the words after the program's name: one line per candidate, with its
/// description after a tab; or ":file" or ":folder".
[[nodiscard]] std::string completions(const CLI::App& program, std::vector<std::string> words);

}  // namespace alidade
