// SPDX-License-Identifier: MIT
#include "unknown_words.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "flags.h"

namespace alidade {
namespace {

std::vector<std::string> commandsOf(const CLI::App& app) {
  return mapped(app.get_subcommands({}), [](const CLI::App* command) { return command->get_name(); });
}

std::string prefixOf(const CLI::App& app) {
  return app.get_parent() == nullptr ? "" : commandName(app) + ": ";
}

std::vector<std::string> flagsOf(const CLI::App& app) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  }
  return flags;
}

// The next step after unknown words: the nearest flag, or the help.
std::string flagAdvice(const std::vector<std::string>& words, const std::vector<std::string>& flags,
                       const std::string& help) {
  for (const std::string& word : words) {
    if (!word.starts_with("-")) continue;
    if (const auto nearest = nearestName(word.substr(0, word.find('=')), flags))
      return "\n  next: did you mean '" + *nearest + "'?";
  }
  return "\n  next: " + help;
}

// The error for a command line that names no command of a program or group.
std::string explainNoCommand(const CLI::App& app, std::vector<std::string> words) {
  const std::string prefix = prefixOf(app);
  const std::string help = callOf(app) + " --help";
  const auto word = std::find_if(words.begin(), words.end(), [](const auto& w) { return w[0] != '-'; });
  if (word != words.end()) return explainUnknownCommand(app, *word);
  if (words.empty())
    return prefix + "no command; expected one of " + join(commandsOf(app), ", ") + "\n  next: " + help;
  return prefix + "unknown flag '" + words[0] + "'; expected a command, or " + join(flagsOf(app), ", ") +
         flagAdvice(words, flagsOf(app), help);
}

}  // namespace

CLI::App& chosenParser(CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? app : chosenParser(*chosen.front());
}

std::string explainUnknownCommand(const CLI::App& app, const std::string& word) {
  const std::vector<std::string> known = commandsOf(app);
  const std::string help = callOf(app) + " --help";
  if (known.empty()) return prefixOf(app) + "this command has no command '" + word + "'\n  next: " + help;
  return prefixOf(app) + "unknown command '" + word + "'; expected one of " + join(known, ", ") +
         "\n  next: " + didYouMean(word, known, help);
}

std::string explainRefusal(const CLI::Error& error, CLI::App& app, int argc, char** argv) {
  const CLI::App& parser = chosenParser(app);
  if (!parser.get_subcommands({}).empty()) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    const auto group = std::ranges::find(words, parser.get_name());
    return explainNoCommand(parser, {group == words.end() ? words.begin() : group + 1, words.end()});
  }
  const std::string text = commandName(parser) + ": " + error.what();
  if (text.find("\n  next: ") != std::string::npos) return text;
  return text + flagAdvice(app.remaining(true), flagsOf(parser), callOf(parser) + " --help");
}

}  // namespace alidade
