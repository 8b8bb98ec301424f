// SPDX-License-Identifier: MIT
#include "help/man_page.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "console.h"

namespace alidade {
namespace {

// What every command ends with, unless it says more. docs/conventions.md has the same list.
constexpr std::array<std::string_view, 4> kExitMeanings = {
    "done", "an input cannot be used, or an output cannot be written",
    "wrong usage: unknown command or flag, malformed board SPEC",
    "done, but the input or result was rejected"};
constexpr int kRejected = 3;

bool isWordCharacter(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0;
}

// Text as roff reads it, in one line. A hyphen-minus is written as "\-" where users would copy it: in flags,
// numbers and, with `is_code`, everywhere. Long lists without blanks may be broken behind their commas.
std::string roff(std::string_view text, bool is_code = false) {
  constexpr std::size_t kLongWord = 24;
  std::string result;
  bool is_flag = false;
  std::size_t word_start = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const char before = i == 0 ? ' ' : text[i - 1];
    if (c == ' ') {
      is_flag = false;
      word_start = i + 1;
    }
    if (c == '-' && !isWordCharacter(before)) is_flag = true;
    switch (c) {
      case '\\':
        result += "\\e";
        break;
      case '-':
        result += is_code || is_flag ? "\\-" : "-";
        break;
      case '\'':
        result += "\\(aq";
        break;
      case '^':
        result += "\\(ha";
        break;
      case '~':
        result += "\\(ti";
        break;
      case '`':
        result += "\\(ga";
        break;
      default:
        result += c;
    }
    const std::size_t word_end = std::min(text.find(' ', word_start), text.size());
    if (!is_code && c == ',' && i + 1 < word_end && word_end - word_start > kLongWord) result += "\\:";
  }
  // Lines that begin with these would be requests.
  return result.starts_with('.') || result.starts_with("\\(aq") ? "\\&" + result : result;
}

std::string bold(std::string_view text) {
  return "\\fB" + roff(text, true) + "\\fR";
}
std::string italic(std::string_view text) {
  return "\\fI" + roff(text, true) + "\\fR";
}

std::string sentence(const std::string& text) {
  return roff(text) + (text.ends_with('.') ? "\n" : ".\n");
}

// "[input...]"
std::string argumentInSynopsis(const FlagText& argument) {
  return "[" + italic(argument.names.front()) + (argument.is_list ? "..." : "") + "]";
}

std::string synopsis(const CommandText& command) {
  std::string text = ".SH SYNOPSIS\n" + bold(command.call);
  if (!command.flags.empty()) text += " [" + italic("OPTION") + "...]";
  for (const FlagText& argument : command.arguments) text += " " + argumentInSynopsis(argument);
  if (!command.commands.empty()) text += " " + italic("COMMAND") + " [" + italic("ARGUMENT") + "...]";
  return text + "\n";
}

// "-o, --output FILE" and what it does.
std::string flagEntry(const FlagText& flag) {
  const bool is_argument = !flag.names.front().starts_with('-');
  std::string text =
      ".TP\n" + (is_argument ? italic(flag.names.front())
                             : join(mapped(flag.names, [](const auto& n) { return bold(n); }), ", "));
  if (!is_argument && !flag.value.empty()) text += " " + italic(flag.value);
  if (flag.is_list) text += " ...";
  text += "\n" + sentence(flag.text);
  const auto isNamed = [&](const std::string& choice) { return flag.text.find(choice) != std::string::npos; };
  if (!std::ranges::all_of(flag.choices, isNamed)) text += "One of " + roff(join(flag.choices, ", ")) + ".\n";
  if (!flag.default_value.empty()) text += "Default: " + roff(flag.default_value) + ".\n";
  return text;
}

// Under a heading for each group; the first one needs none.
std::string options(const CommandText& command) {
  std::vector<std::string> groups;
  for (const FlagText& flag : command.flags) {
    if (std::ranges::find(groups, flag.group) == groups.end()) groups.push_back(flag.group);
  }
  std::string text = ".SH OPTIONS\n";
  for (const std::string& group : groups) {
    if (group != groups.front()) text += ".SS " + roff(group) + "\n";
    for (const FlagText& flag : command.flags) {
      if (flag.group == group) text += flagEntry(flag);
    }
  }
  return text;
}

std::string exitStatus(const CommandText& command) {
  std::string text = ".SH EXIT STATUS\n";
  for (int code = 0; code <= kRejected; ++code) {
    const auto own = command.exit_codes.find(code);
    const bool is_own = own != command.exit_codes.end();
    if (code == kRejected && !is_own && command.commands.empty()) continue;  // the command never rejects
    const std::string meaning =
        is_own ? own->second : std::string(kExitMeanings.at(static_cast<std::size_t>(code)));
    text += fmt::format(".TP\n\\fB{}\\fR\n{}", code, sentence(meaning));
  }
  return text;
}

// Its own, and the first one of each command of a group.
std::vector<std::string> examplesOf(const CommandText& command) {
  std::vector<std::string> examples = command.examples;
  for (const CommandText& child : command.commands) {
    const std::vector<std::string> more = examplesOf(child);
    if (!more.empty() && std::ranges::find(examples, more.front()) == examples.end())
      examples.push_back(more.front());
  }
  return examples;
}

std::string examples(const CommandText& command) {
  std::string text = ".SH EXAMPLES\n";
  for (const std::string& example : examplesOf(command))
    text += ".PP\n.EX\n" + roff(example, true) + "\n.EE\n";
  return text;
}

std::string reference(const CommandText& command) {
  return "\\%" + bold(manPageName(command)) + "(1)";  // not hyphenated
}

// All other pages.
void addOthers(const CommandText& command, const CommandText& from, std::vector<std::string>& found) {
  if (from.call != command.call) found.push_back(reference(from));
  for (const CommandText& child : from.commands) addOthers(command, child, found);
}

std::string seeAlso(const CommandText& command, const CommandText& program) {
  std::vector<std::string> others;
  addOthers(command, program, others);
  return ".SH SEE ALSO\n" + join(others, ",\n") + "\n";
}

std::string loweredFirst(std::string text) {
  text.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(text.front())));
  return text;
}

}  // namespace

std::string manPageName(const CommandText& command) {
  std::string name = command.call;
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string manPage(const CommandText& command, const CommandText& program) {
  std::string title = manPageName(command);
  std::ranges::transform(title, title.begin(), [](unsigned char c) { return std::toupper(c); });
  // Left-aligned, as long words would otherwise tear lines apart.
  std::string page =
      fmt::format(".TH {} 1 \"\" \"{}\" \"Alidade\"\n.ad l\n", roff(title, true), programName());
  page +=
      ".SH NAME\n" + roff(manPageName(command), true) + " \\- " + roff(loweredFirst(command.summary)) + "\n";
  page += synopsis(command);
  page += ".SH DESCRIPTION\n" + sentence(command.summary);
  for (const std::string& note : command.notes) page += ".PP\n" + sentence(note);
  if (!command.commands.empty()) page += ".SH COMMANDS\n";
  for (const CommandText& child : command.commands)
    page += ".TP\n" + reference(child) + "\n" + sentence(child.summary);
  if (!command.arguments.empty()) page += ".SH ARGUMENTS\n";
  for (const FlagText& argument : command.arguments) page += flagEntry(argument);
  return page + options(command) + exitStatus(command) + examples(command) + seeAlso(command, program);
}

}  // namespace alidade
