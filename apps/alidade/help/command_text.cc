// SPDX-License-Identifier: MIT
#include "help/command_text.h"

#include <algorithm>
#include <string_view>

#include <CLI/CLI.hpp>

#include "alidade/core/text.h"
#include "options.h"

namespace alidade {
namespace {

FlagText flagTextOf(const CLI::Option& option) {
  FlagText flag{.names = {}, .value = {}};
  if (option.get_positional()) {
    flag.names = {option.get_name(true)};
  } else {
    for (const std::string& name : option.get_snames()) flag.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) flag.names.push_back("--" + name);
  }
  // "FILE", "INT:0 to 1024" or "TEXT:{radtan,fov}"
  const std::string type = option.get_type_size_min() == 0 ? "" : option.get_type_name();
  flag.value = type.substr(0, type.find(':'));
  const std::size_t open = type.find(":{");
  if (open != std::string::npos) {
    const std::string list = type.substr(open + 2, type.find('}', open) - open - 2);
    for (const std::string_view choice : split(list, ',')) flag.choices.emplace_back(choice);
  }
  flag.is_list = !flag.value.empty() && option.get_items_expected_max() > 1;
  flag.default_value = option.get_default_str();
  flag.text = option.get_description();
  flag.group = option.get_group();
  return flag;
}

// "Exit code 3: a file failed." or "Exit code 0: no file failed; 3: a file failed."; a part without a number
// belongs to the one before it.
void readExitCodes(std::string_view text, std::map<int, std::string>& codes) {
  if (text.ends_with('.')) text.remove_suffix(1);
  int code = 0;
  for (std::string_view part : split(text, ';')) {
    part = trim(part);
    if (const std::size_t colon = part.find(": "); colon != std::string_view::npos) {
      if (const auto number = parseInt(part.substr(0, colon))) {
        code = *number;
        part.remove_prefix(colon + 2);
      }
    }
    std::string& meaning = codes[code];
    meaning += (meaning.empty() ? "" : "; ") + std::string(part);
  }
}

// The lines of a help text that are neither the summary nor flags.
void readLines(std::string_view lines, CommandText& command) {
  constexpr std::string_view kExample = "Example: ";
  constexpr std::string_view kExitCode = "Exit code ";
  bool is_continued = false;
  for (const std::string_view line : split(lines, '\n')) {
    if (line.starts_with(kExample)) {
      command.examples.emplace_back(line.substr(kExample.size()));
      is_continued = false;
    } else if (line.starts_with(kExitCode)) {
      readExitCodes(line.substr(kExitCode.size()), command.exit_codes);
      is_continued = false;
    } else if (!line.empty()) {
      if (is_continued) {
        command.notes.back() += " " + std::string(line);
      } else {
        command.notes.emplace_back(line);
      }
      is_continued = !line.ends_with('.');  // lines are broken inside of sentences
    }
  }
}

}  // namespace

WordKind FlagText::kind() const {
  if (value == kFolderValue) return WordKind::kFolder;
  if (value == kFileValue || value == kSpecValue) return WordKind::kFile;  // a SPEC may be a file
  return value == kCommandValue ? WordKind::kCommand : WordKind::kNothing;
}

std::string FlagText::summary() const {
  std::size_t end = text.size();
  for (const char* mark : {". ", ": ", "; ", " ("}) end = std::min(end, text.find(mark));
  return text.substr(0, end);
}

CommandText commandTextOf(const CLI::App& app) {
  const std::string description = app.get_description();
  const std::size_t line_end = description.find('\n');
  CommandText command{.call = callOf(app),
                      .name = app.get_name(),
                      .summary = description.substr(0, line_end),
                      .arguments = {},
                      .flags = {},
                      .commands = {},
                      .examples = {},
                      .notes = {},
                      .exit_codes = {}};
  if (command.summary.ends_with('.')) command.summary.pop_back();
  if (line_end != std::string::npos) readLines(description.substr(line_end + 1), command);
  readLines(app.get_footer(), command);
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
    (option->get_positional() ? command.arguments : command.flags).push_back(flagTextOf(*option));
  }
  for (const CLI::App* child : app.get_subcommands({})) command.commands.push_back(commandTextOf(*child));
  return command;
}

}  // namespace alidade
