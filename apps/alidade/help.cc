// SPDX-License-Identifier: MIT
#include "help.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "command.h"
#include "console.h"
#include "unknown_words.h"

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
  if (type == kFile.word || type == kSpec.word) return ":file";
  const std::size_t open = type.find(":{");
  if (open == std::string::npos) return "";
  const std::string choices = type.substr(open + 2, type.find('}', open) - open - 2);
  std::string text;
  for (const std::string_view choice : split(choices, ','))
    text += candidate(prefix + std::string(choice), "");
  return text;
}

class HelpCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade help calibrate\nExample: alidade help rig calibrate\n"
        "Prints the same as --help of the command; without a command, the list of commands.");
    flags.add("command", &words_, "Command, or group and command", {.word = kCommandWord});
  }

  int run(const Flags& flags) override {
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

std::unique_ptr<Command> makeHelpCommand() {
  return std::make_unique<HelpCommand>();
}

}  // namespace alidade
