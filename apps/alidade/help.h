// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace alidade {

/// Completions of the last of the words behind the program's name: a line for each candidate, with its
/// meaning behind a tabulator; or ":file" or ":folder".
[[nodiscard]] std::string completions(const CLI::App& program, std::vector<std::string> words);

}  // namespace alidade
