// SPDX-License-Identifier: MIT
#include "help/completion.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "console.h"

namespace alidade {
namespace {

// A command as the scripts know it: by the words that were typed after the program's name.
struct Typed {
  std::string words;  // "rig calibrate"; empty: none yet
  std::string summary;
  std::vector<FlagText> flags;
  std::vector<FlagText> arguments;
  std::vector<const CommandText*> commands;  // that may be the next word
};

void addTyped(const CommandText& command, const std::string& words, bool is_topic,
              std::vector<Typed>& found) {
  Typed typed{.words = words, .summary = command.summary, .flags = {}, .arguments = {}, .commands = {}};
  if (!is_topic) {
    typed.flags = command.flags;
    typed.arguments = command.arguments;
  }
  for (const CommandText& child : command.commands) typed.commands.push_back(&child);
  found.push_back(typed);
  const std::string start = words.empty() ? "" : words + " ";
  for (const CommandText& child : command.commands) addTyped(child, start + child.name, is_topic, found);
}

// The program, its groups and its commands. A command whose arguments are commands ("help") has all of them
// below it once more.
std::vector<Typed> typedCommands(const CommandText& program) {
  std::vector<Typed> all;
  addTyped(program, "", false, all);
  std::vector<Typed> result;
  for (const Typed& typed : all) {
    const bool takes_commands = std::ranges::any_of(
        typed.arguments, [](const FlagText& argument) { return argument.kind() == WordKind::kCommand; });
    if (!takes_commands) {
      result.push_back(typed);
      continue;
    }
    std::vector<Typed> topics;
    addTyped(program, typed.words, true, topics);
    topics.front().flags = typed.flags;
    result.insert(result.end(), topics.begin(), topics.end());
  }
  return result;
}

std::vector<std::string> namesOf(const std::vector<FlagText>& flags) {
  std::vector<std::string> names;
  for (const FlagText& flag : flags) names.insert(names.end(), flag.names.begin(), flag.names.end());
  return names;
}

std::string withoutDashes(std::string_view name) {
  return std::string(name.substr(name.find_first_not_of('-')));
}

std::string header(std::string_view comment) {
  return fmt::format("{} of {}; written by: alidade help --write FOLDER\n", comment, programName());
}

// ---- bash ----

std::string bashValues(const FlagText& flag) {
  if (!flag.choices.empty()) return "'" + join(flag.choices, " ") + "'";
  return flag.kind() == WordKind::kFile ? ":file" : flag.kind() == WordKind::kFolder ? ":folder" : ":nothing";
}

std::string bashCase(const Typed& typed) {
  std::string text = fmt::format("    '{}')\n", typed.words.empty() ? "" : " " + typed.words);
  if (!typed.flags.empty()) text += "      flags='" + join(namesOf(typed.flags), " ") + "'\n";
  if (!typed.commands.empty()) {
    text += "      words='" +
            join(mapped(typed.commands, [](const CommandText* command) { return command->name; }), " ") +
            "'\n";
  } else if (!typed.arguments.empty()) {
    text += "      words=:file\n";
  }
  std::string values;
  for (const FlagText& flag : typed.flags) {
    if (!flag.value.empty())
      values += fmt::format("        {}) words={} flags='' ;;\n", join(flag.names, " | "), bashValues(flag));
  }
  return text + (values.empty() ? "" : "      case $flag in\n" + values + "      esac\n") + "      ;;\n";
}

// ---- zsh ----

// Inside of single quotes.
std::string zshQuoted(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
      result += c;
    }
  }
  return result;
}

std::string zshFunction(std::string words) {
  std::ranges::replace(words, ' ', '_');
  return words.empty() ? "_alidade" : "_alidade_" + words;
}

std::string zshAction(const FlagText& flag) {
  if (!flag.choices.empty()) return "(" + join(flag.choices, " ") + ")";
  return flag.kind() == WordKind::kFile ? "_files" : flag.kind() == WordKind::kFolder ? "_files -/" : " ";
}

// The lines of _arguments for one flag: one for each of its names.
std::string zshFlag(const FlagText& flag) {
  std::string text;
  for (const std::string& name : flag.names) {
    const std::string start = flag.is_list ? "*" : "(" + join(flag.names, " ") + ")";
    const std::string end = flag.value.empty() ? "" : name.starts_with("--") ? "=" : "+";
    text += fmt::format(" \\\n    '{}{}{}[{}]", start, name, end, zshQuoted(flag.summary()));
    if (!flag.value.empty()) text += ":" + zshQuoted(flag.value) + ":" + zshAction(flag);
    text += "'";
  }
  return text;
}

std::string zshCommand(const Typed& typed) {
  std::string text = zshFunction(typed.words) + "() {\n";
  std::string flags;
  for (const FlagText& flag : typed.flags) flags += zshFlag(flag);
  if (typed.commands.empty() && typed.arguments.empty() && flags.empty())
    return text + "  _message 'no more arguments'\n}\n\n";
  if (typed.commands.empty()) {
    text += "  _arguments" + flags;
    for (const FlagText& argument : typed.arguments) {
      text += fmt::format(" \\\n    '{}:{}:_files'", argument.is_list ? "*" : "",
                          zshQuoted(argument.names.front()));
    }
    return text + "\n}\n\n";
  }
  text +=
      "  local curcontext=$curcontext state state_descr line\n  local -i missed=1\n  typeset -A opt_args\n";
  text += "  local -a commands=(\n";
  for (const CommandText* command : typed.commands)
    text += fmt::format("    '{}:{}'\n", command->name, zshQuoted(command->summary));
  text += "  )\n  _arguments -C" + flags +
          " \\\n    '1:command:->command' \\\n    '*::argument:->argument' && missed=0\n";
  text +=
      "  case $state in\n    command) _describe -t commands command commands && missed=0 ;;\n    argument)\n "
      "     case $line[1] in\n";
  for (const CommandText* command : typed.commands) {
    const std::string words = (typed.words.empty() ? "" : typed.words + " ") + command->name;
    text += fmt::format("        {}) {} && missed=0 ;;\n", command->name, zshFunction(words));
  }
  return text + "      esac\n      ;;\n  esac\n  return missed\n}\n\n";
}

// ---- fish ----

// Inside of single quotes.
std::string fishQuoted(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'' || c == '\\') result += '\\';
    result += c;
  }
  return result;
}

std::string fishFlag(const FlagText& flag) {
  std::string text;
  for (const std::string& name : flag.names)
    text += (name.starts_with("--") ? " -l " : " -s ") + withoutDashes(name);
  if (!flag.choices.empty()) {
    text += " -x -a '" + join(flag.choices, " ") + "'";
  } else if (!flag.value.empty()) {
    text += flag.kind() == WordKind::kFile     ? " -r -F"
            : flag.kind() == WordKind::kFolder ? " -x -a '(__fish_complete_directories)'"
                                               : " -x";
  }
  return text + " -d '" + fishQuoted(flag.summary()) + "'\n";
}

std::string fishCommand(const Typed& typed) {
  const std::string start = fmt::format("complete -c alidade -n '__alidade_at \"{}\"'", typed.words);
  std::string text;
  for (const CommandText* command : typed.commands)
    text += fmt::format("{} -a {} -d '{}'\n", start, command->name, fishQuoted(command->summary));
  for (const FlagText& flag : typed.flags) text += start + fishFlag(flag);
  if (typed.commands.empty() && !typed.arguments.empty()) text += start + " -F\n";
  return text;
}

}  // namespace

std::string bashCompletion(const CommandText& program) {
  std::string known;
  std::string cases;
  for (const Typed& typed : typedCommands(program)) {
    if (!typed.words.empty()) known += (known.empty() ? "' " : " | \\\n        ' ") + typed.words + "'";
    cases += bashCase(typed);
  }
  return header("# bash completion") + R"(
_alidade() {
  local current=${COMP_WORDS[COMP_CWORD]} flag=${COMP_WORDS[COMP_CWORD - 1]} command='' flags='' words='' i
  COMPREPLY=()
  # "--model=rad" is three words: --model, = and rad.
  if [[ $current == = ]]; then
    current=''
  elif [[ $flag == = && $COMP_CWORD -gt 1 ]]; then
    flag=${COMP_WORDS[COMP_CWORD - 2]}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$command ${COMP_WORDS[i]}" in
      )" +
         known + R"()
        command+=" ${COMP_WORDS[i]}"
        ;;
    esac
  done
  case $command in
)" + cases +
         R"(  esac
  if [[ $current == -* && -n $flags ]]; then
    words=$flags
  fi
  case $words in
    :file) compopt -o default ;;
    :folder) compopt -o dirnames ;;
    :nothing) ;;
    *) mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current") ;;
  esac
} && complete -F _alidade alidade
)";
}

std::string zshCompletion(const CommandText& program) {
  std::string text = "#compdef alidade\n" + header("# zsh completion") + "\n";
  for (const Typed& typed : typedCommands(program)) text += zshCommand(typed);
  return text + R"(if [[ $funcstack[1] == _alidade ]]; then
  _alidade "$@"
else
  compdef _alidade alidade
fi
)";
}

std::string fishCompletion(const CommandText& program) {
  std::string known;
  std::string lines;
  for (const Typed& typed : typedCommands(program)) {
    if (!typed.words.empty()) known += fmt::format(" '{}'", typed.words);
    lines += fishCommand(typed);
  }
  return header("# fish completion") + R"(
# Whether the words before the cursor name this command.
function __alidade_at
    set -l known)" +
         known + R"(
    set -l command
    for word in (commandline -opc)[2..-1]
        set -l longer (string join ' ' -- $command $word)
        if contains -- $longer $known
            set command $longer
        end
    end
    test "$command" = "$argv[1]"
end

complete -c alidade -f
)" + lines;
}

}  // namespace alidade
