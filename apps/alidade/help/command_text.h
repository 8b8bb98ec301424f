// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <vector>

// What the program knows of its commands, as plain data: for its man pages and for the completion of shells.

namespace CLI {
class App;
}  // namespace CLI

namespace alidade {

/// What a shell can offer for a word.
enum class WordKind { kNothing, kFile, kFolder, kCommand };

/// A flag, or an argument without one.
struct FlagText {
  std::vector<std::string> names;      ///< {"-o", "--output"}; of an argument {"input"}
  std::string value;                   ///< "FILE"; empty: the flag has no value
  std::vector<std::string> choices{};  ///< all values that are accepted; empty: not a list
  bool is_list = false;                ///< several values are accepted
  std::string default_value{};         ///< empty: none that is worth a word
  std::string text{};                  ///< what it does
  std::string group{};                 ///< the heading that it stands under

  [[nodiscard]] WordKind kind() const;
  /// The first words of `text`, short enough for a list of flags.
  [[nodiscard]] std::string summary() const;
};

/// A command, a group of commands, or the program.
struct CommandText {
  std::string call;     ///< "alidade rig calibrate"
  std::string name;     ///< "calibrate"
  std::string summary;  ///< one sentence, without a full stop
  std::vector<FlagText> arguments;
  std::vector<FlagText> flags;
  std::vector<CommandText> commands;      ///< of a group or the program
  std::vector<std::string> examples;      ///< command lines
  std::vector<std::string> notes;         ///< paragraphs
  std::map<int, std::string> exit_codes;  ///< those that the command explains itself
};

/// Everything that the parser of the program, a group or a command says in its help.
[[nodiscard]] CommandText commandTextOf(const CLI::App& app);

}  // namespace alidade
