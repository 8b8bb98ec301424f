// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace alidade {

/// The error for a command line that the parser of `app` refused, with the nearest valid word.
[[nodiscard]] std::string explainRefusal(const CLI::Error& error, CLI::App& app, int argc, char** argv);

/// The same for a word that is not a command of a program or group.
[[nodiscard]] std::string explainUnknownCommand(const CLI::App& app, const std::string& word);

/// The parser of the named command, or of the group or program if no command was named.
[[nodiscard]] CLI::App& chosenParser(CLI::App& app);

}  // namespace alidade
