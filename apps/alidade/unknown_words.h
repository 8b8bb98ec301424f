// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace alidade {

/// The complaint about a command line that the parser of `app` refused, with the nearest thing it accepts.
[[nodiscard]] std::string explainRefusal(const CLI::Error& error, CLI::App& app, int argc, char** argv);

/// The same of a word that is no command of a program or group.
[[nodiscard]] std::string explainUnknownCommand(const CLI::App& app, const std::string& word);

/// The parser of the command that was named, or of the group or the whole program where no command was.
[[nodiscard]] CLI::App& chosenParser(CLI::App& app);

}  // namespace alidade
