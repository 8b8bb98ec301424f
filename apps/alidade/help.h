// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace alidade {

/// Completions of the last of the words after the program's name: one line per candidate, with its
/// description after a tab; or ":file" or ":folder".
[[nodiscard]] std::string completions(const CLI::App& program, std::vector<std::string> words);

/// The error for a command line that the parser of `app` refused, with the nearest valid word.
[[nodiscard]] std::string explainRefusal(const CLI::Error& error, CLI::App& app, int argc, char** argv);

/// The parser of the named command, or of the group or program if no command was named.
[[nodiscard]] CLI::App& chosenParser(CLI::App& app);

}  // namespace alidade
