// SPDX-License-Identifier: MIT
#include <filesystem>
#include <system_error>

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/files/text/atomic_file.h"
#include "console.h"
#include "help/command_text.h"
#include "help/completion.h"
#include "help/man_page.h"
#include "help/unknown_words.h"
#include "options.h"

namespace alidade {
namespace {

// Creates the folders that lead to the file.
void writeBelow(const std::filesystem::path& folder, const std::string& name, const std::string& text) {
  const std::filesystem::path path = folder / name;
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  if (error) {
    throw inputError({.where = path.parent_path().string(),
                      .found = "cannot be created: " + error.message(),
                      .expected = "a folder, or a name for one",
                      .next_step = "choose another folder for --write"});
  }
  writeFileAtomically(path.string(), text, Durability::kQuick);
}

void writePages(const std::filesystem::path& folder, const CommandText& command, const CommandText& program) {
  writeBelow(folder, "man/man1/" + manPageName(command) + ".1", manPage(command, program));
  for (const CommandText& child : command.commands) writePages(folder, child, program);
}

class HelpCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade help calibrate\nExample: alidade help rig calibrate\n"
        "Prints the same as --help of the command; without a command, the list of commands.\n"
        "--write creates man/man1/alidade.1 and one page for each command, "
        "bash-completion/completions/alidade,\n"
        "zsh/vendor-completions/_alidade and fish/vendor_completions.d/alidade.fish. Earlier files of these "
        "names\n"
        "are replaced.");
    app.add_option("command", words_, "Command, or group and command")->type_name(kCommandValue);
    app.add_option("--write", folder_,
                   "Folder to write the man pages and the completions of bash, zsh and fish to")
        ->type_name(kFolderValue);
  }

  int run(const CLI::App& app) override {
    const CLI::App& program = *app.get_parent();
    if (!folder_.empty()) {
      if (!words_.empty()) {
        throw usageError({.where = "help",
                          .found = "--write and a command",
                          .expected = "one of them: --write writes the pages of all commands"});
      }
      writeAll(commandTextOf(program));
      return 0;
    }
    const CLI::App* topic = &program;
    for (std::size_t i = 0; i < words_.size(); ++i) {
      const CLI::App* next = nullptr;
      for (const CLI::App* command : topic->get_subcommands({})) {
        if (command->get_name() == words_[i]) next = command;
      }
      if (next == nullptr) throw usageError({.found = explainUnknownCommand(*topic, words_[i])});
      topic = next;
    }
    printResult(topic->get_formatter()->make_help(topic, callOf(*topic), CLI::AppFormatMode::Normal));
    return 0;
  }

 private:
  void writeAll(const CommandText& program) const {
    const std::filesystem::path folder = folder_;
    writePages(folder, program, program);
    writeBelow(folder, "bash-completion/completions/alidade", bashCompletion(program));
    writeBelow(folder, "zsh/vendor-completions/_alidade", zshCompletion(program));
    writeBelow(folder, "fish/vendor_completions.d/alidade.fish", fishCompletion(program));
  }

  std::vector<std::string> words_;
  std::string folder_;
};

}  // namespace

std::unique_ptr<Command> makeHelpCommand() {
  return std::make_unique<HelpCommand>();
}

}  // namespace alidade
