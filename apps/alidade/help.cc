// SPDX-License-Identifier: MIT
#include "help.h"

#include <algorithm>
#include <optional>

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "board_views.h"
#include "command.h"
#include "console.h"
#include "flags.h"

namespace alidade {
namespace {

constexpr const char* kCommandWord = "COMMAND";

const CLI::App* childOf(const CLI::App& app, const std::string& name) {
  const auto children = app.get_subcommands({});
  const auto child = std::ranges::find(children, name, &CLI::App::get_name);
  return child == children.end() ? nullptr : *child;
}

bool takesCommands(const CLI::App& app) {
  return std::ranges::any_of(app.get_options(), [](const CLI::Option* option) {
    return option->get_positional() && option->get_type_name() == kCommandWord;
  });
}

// A candidate with the first words of its description.
std::string candidate(const std::string& word, const std::string& text) {
  std::size_t end = text.size();
  for (const char* mark : {"\n", ". ", ": ", "; ", " ("}) end = std::min(end, text.find(mark));
  return word + "\t" + text.substr(0, end) + "\n";
}

std::string flagCandidates(const CLI::App& app) {
  std::string text;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_snames())
      text += candidate("-" + name, option->get_description());
    for (const std::string& name : option->get_lnames())
      text += candidate("--" + name, option->get_description());
  }
  return text;
}

// The values of a flag, from its help text: "FILE", "INT:0 to 1024" or "TEXT:{radtan,fov}".
std::string valueCandidates(const CLI::Option& flag, const std::string& prefix) {
  const std::string type = flag.get_type_name();
  if (type == kFolder.word) return ":folder";
  if (type == kFilePath.word || type == kSpec.word) return ":file";
  const std::size_t open = type.find(":{");
  if (open == std::string::npos) return "";
  const std::string choices = type.substr(open + 2, type.find('}', open) - open - 2);
  std::string text;
  for (const std::string_view choice : split(choices, ','))
    text += candidate(prefix + std::string(choice), "");
  return text;
}

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

// The next step after unknown words: the nearest flag, the flag of an output, or the help.
std::string flagAdvice(const std::vector<std::string>& words, const std::vector<std::string>& flags,
                       const std::string& help) {
  for (const std::string& word : words) {
    if (!word.starts_with("-")) continue;
    const std::string flag = word.substr(0, word.find('='));
    const auto begins = [&](const std::string& known) { return known.starts_with(flag); };  // "--out"
    const auto longer = std::ranges::find_if(flags, begins);
    const auto nearest = longer == flags.end() || flag.size() < 4 ? nearestName(flag, flags) : *longer;
    if (nearest) return "\n  next: did you mean '" + *nearest + "'?";
  }
  const bool has_output = std::ranges::find(flags, "--output") != flags.end();
  if (has_output && words.size() == 1 && words.front().find('.') != std::string::npos)
    return "\n  next: did you mean '-o " + words.front() + "'?";
  return "\n  next: " + help;
}

// The error for a word that is no command of a program or group.
std::string explainUnknownCommand(const CLI::App& app, const std::string& word) {
  const std::vector<std::string> known = commandsOf(app);
  const std::string help = callOf(app) + " --help";
  if (known.empty()) return prefixOf(app) + "this command has no command '" + word + "'\n  next: " + help;
  return prefixOf(app) + "unknown command '" + word + "'; expected one of " + join(known, ", ") +
         "\n  next: " + didYouMean(word, known, help);
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

class HelpCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade help calibrate\nExample: alidade help rig calibrate\nExample: alidade help boards\n"
        "Prints the same as --help of the command; without a command, the list of commands. boards: the kinds "
        "of boards, and how to name them.");
    flags.add("command", &words_, "Command, or group and command", {.word = kCommandWord});
  }

  int run(const Flags& flags) override {
    if (words_ == std::vector<std::string>{"boards"}) {
      printResult(boardsHelp());
      return 0;
    }
    const CLI::App* topic = flags.parser().get_parent();
    for (const std::string& word : words_) {
      const CLI::App* const next = childOf(*topic, word);
      if (next == nullptr) throw usageError({.found = explainUnknownCommand(*topic, word)});
      topic = next;
    }
    printResult(topic->get_formatter()->make_help(topic, callOf(*topic), CLI::AppFormatMode::Normal));
    return 0;
  }

 private:
  std::vector<std::string> words_;
};

}  // namespace

std::string completions(const CLI::App& program, std::vector<std::string> words) {
  if (words.empty() || words.back() == "=") words.emplace_back();
  std::erase(words, "=");  // bash splits "--model=radtan" into three words
  std::string prefix;
  if (const std::size_t end = words.back().find('='); end != std::string::npos) {
    prefix = words.back().substr(0, end + 1);
    words.insert(words.end() - 1, words.back().substr(0, end));
  }
  const std::string current = words.back();
  words.pop_back();
  const CLI::App* command = &program;
  const CLI::App* with_flags = &program;  // null: a command named after "help"
  const CLI::Option* open = nullptr;      // the flag that expects a value next
  for (const std::string& word : words) {
    const CLI::Option* const flag =
        with_flags != nullptr && word.starts_with('-') ? with_flags->get_option_no_throw(word) : nullptr;
    open = flag != nullptr && flag->get_type_size_min() > 0 ? flag : nullptr;
    const CLI::App* const next = childOf(*command, word);
    if (next == nullptr) continue;
    with_flags = command == with_flags ? next : nullptr;
    command = takesCommands(*next) ? &program : next;
  }
  if (open != nullptr) return valueCandidates(*open, prefix);
  if (with_flags != nullptr && current.starts_with('-')) return flagCandidates(*with_flags);
  std::string text;
  for (const CLI::App* child : command->get_subcommands({}))
    text += candidate(child->get_name(), child->get_description());
  return text.empty() && with_flags != nullptr ? ":file" : text;
}

CLI::App& chosenParser(CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? app : chosenParser(*chosen.front());
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

const CommandEntry kHelpCommand = {"help", "Show the help of a command", made<HelpCommand>};

}  // namespace alidade
