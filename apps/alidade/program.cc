// SPDX-License-Identifier: MIT
#include "program.h"

#include <array>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include <CLI/CLI.hpp>

#include "alidade/core/cancel.h"
#include "alidade/core/error.h"
#include "alidade/detect/detect_images.h"
#include "alidade/report/data/json_output.h"
#include "command.h"
#include "console.h"
#include "help.h"

namespace alidade {
namespace {

// Of the groups of commands.
const std::map<std::string, const char*> kGroupSummaries = {
    {"rig", "Several cameras that are fixed to each other"},
    {"handeye", "A camera on a robot's hand, or beside a robot"}};

// In the order of the help text.
const std::array<const CommandEntry*, 22> kCommands = {&kCalibrateCommand,
                                                       &kDetectCommand,
                                                       &kRigCalibrateCommand,
                                                       &kRigValidateCommand,
                                                       &kRigRectifyCommand,
                                                       &kRigTriangulateCommand,
                                                       &kHandEyeCalibrateCommand,
                                                       &kHandEyeValidateCommand,
                                                       &kProjectCommand,
                                                       &kUnprojectCommand,
                                                       &kPoseCommand,
                                                       &kUndistortCommand,
                                                       &kValidateCommand,
                                                       &kDiffCommand,
                                                       &kFleetCommand,
                                                       &kConvertCommand,
                                                       &kFormatsCommand,
                                                       &kReportCommand,
                                                       &kTrackCommand,
                                                       &kBoardCommand,
                                                       &kSimulateCommand,
                                                       &kHelpCommand};

// The command that shell completion calls, hidden from users.
constexpr std::string_view kCompleteCommand = "complete";

constexpr int kUsageExit = static_cast<int>(ErrorCode::kUsage);

int fail(int code, const std::string& message) {
  printMessage("error: " + message);
  return code;
}

// A shell passes an unset variable in quotes as an empty value, which must not count as "not given".
void refuseEmptyValues(const Flags& flags) {
  for (const CLI::Option* option : flags.parser().get_options()) {
    if (option->get_type_size_min() == 0) continue;  // a flag without a value
    for (const std::string& text : option->results()) {
      if (!text.empty()) continue;
      throw flagError(flags.command() + ": " + option->get_name(), "an empty value", "a value",
                      "if it comes from a shell variable, check that it is set; otherwise remove the flag");
    }
  }
}

int exitCodeOf(const std::exception& error) {
  const auto* known = dynamic_cast<const Error*>(&error);
  return known != nullptr ? static_cast<int>(known->code()) : kInputExit;
}

std::string messageOf(const std::exception& error) {
  if (dynamic_cast<const Error*>(&error) != nullptr) return error.what();
  // OpenCV has its own exception for this.
  const bool is_opencv =
      std::string_view(error.what()).find("(-4:Insufficient memory)") != std::string_view::npos;
  if (is_opencv || dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return std::string(kOutOfMemory);
  return std::string("internal: ") + error.what() +
         "\n  next: this is a bug in alidade; please report it and include the command line";
}

// For callers that read only standard output. Standard error always has the message.
void printErrorJson(const std::exception& error) {
  try {
    printResult(jsonText({{"error", {{"exit_code", exitCodeOf(error)}, {"message", messageOf(error)}}}}));
  } catch (const std::exception&) {
    return;
  }
}

// The parser of a command, inside that of its group.
CLI::App* addParser(CLI::App& app, const CommandEntry& entry) {
  const std::string_view name = entry.name;
  const std::size_t space = name.find(' ');
  if (space == std::string_view::npos) return app.add_subcommand(entry.name, entry.summary);
  const std::string group_name(name.substr(0, space));
  const auto groups =
      app.get_subcommands([&](const CLI::App* other) { return other->get_name() == group_name; });
  CLI::App* group =
      groups.empty() ? app.add_subcommand(group_name, kGroupSummaries.at(group_name)) : groups.front();
  group->require_subcommand(1);
  return group->add_subcommand(std::string(name.substr(space + 1)), entry.summary);
}

int runCommand(int argc, char** argv) {
  CLI::App app(
      "Calibrates cameras from photographs of a board, projects points, and checks whether a camera file can "
      "be trusted.\nExample: alidade calibrate photos/ --board checkerboard:9x6:25mm -o camera.yaml",
      "alidade");
  const auto formatter = std::make_shared<CLI::Formatter>();
  formatter->column_width(34);
  // The parser's own formatter puts two empty lines between groups of flags.
  app.formatter_fn([formatter](const CLI::App* topic, std::string name, CLI::AppFormatMode mode) {
    std::string text = formatter->make_help(topic, std::move(name), mode);
    for (std::size_t i = 0; (i = text.find("\n\n\n")) != std::string::npos;) text.erase(i, 1);
    return text;
  });
  app.set_version_flag("--version", programName());
  app.require_subcommand(1);
  std::map<const CLI::App*, std::pair<Flags, std::unique_ptr<Command>>> commands;
  for (const CommandEntry* const entry : kCommands) {
    CLI::App* const parser = addParser(app, *entry);
    auto& [flags, command] = commands.try_emplace(parser, Flags(*parser), entry->make()).first->second;
    command->setUp(flags);
  }
  if (argc <= 1) {
    printHelp(app.help());
    return kUsageExit;
  }
  if (std::string_view(argv[1]) == kCompleteCommand) {
    printResult(completions(app, {argv + 2, argv + argc}));
    return 0;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    std::ostringstream out;
    std::ostringstream unused;
    const int code = app.exit(e, out, unused);  // --help and --version
    printResult(out.str());
    return code;
  } catch (const CLI::Error& e) {
    const auto chosen = commands.find(&chosenParser(app));
    const std::span<const char* const> words(argv, static_cast<std::size_t>(argc));
    const std::string redirection = chosen == commands.end() ? "" : chosen->second.first.redirection(words);
    return fail(kUsageExit, redirection.empty() ? explainRefusal(e, app, argc, argv) : redirection);
  }
  auto& [flags, command] = commands.at(&chosenParser(app));
  try {
    refuseEmptyValues(flags);
    if (const CLI::Option* config = flags.parser().get_option_no_throw("--config"); config && *config) {
      flags.applySettingsFile(config->as<std::string>());
      refuseEmptyValues(flags);
    }
    return command->run(flags);
  } catch (const Cancelled&) {
    throw;  // ends by the signal, without an exit code or a document
  } catch (const std::exception& error) {
    if (command->owesJson()) printErrorJson(error);
    if (exitCodeOf(error) == kInputExit) command->writeJunitError(messageOf(error));
    throw;
  }
}

}  // namespace

int runProgram(int argc, char** argv) {
  try {
    useOneThreadPerImage();
    return runCommand(argc, argv);
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& e) {
    return fail(exitCodeOf(e), messageOf(e));
  }
}

}  // namespace alidade
