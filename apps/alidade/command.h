// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/core/cancel.h"
#include "alidade/core/error.h"

namespace CLI {
class App;
}

namespace alidade {

/// What every command can be told.
struct CommonOptions {
  bool json = false;
  bool quiet = false;
  int jobs = 0;
  std::string config;
};

/// One command of the program: its flags, and what it does with them.
class Command {
 public:
  virtual ~Command() = default;
  /// Adds flags and help to the command's own parser.
  virtual void setUp(CLI::App& app) = 0;
  /// Does the work. @returns the exit code
  virtual int run(const CLI::App& app) = 0;
  /// Whether standard output is still to get its JSON document, so that an error has to be one.
  [[nodiscard]] virtual bool owesJson() const { return common_.json; }

 protected:
  CommonOptions common_;
};

struct CommandEntry {
  std::string name;
  std::string summary;
  std::unique_ptr<Command> command;
};

/// All commands, in the order of the help text.
[[nodiscard]] std::vector<CommandEntry> makeCommands();

[[nodiscard]] std::unique_ptr<Command> makeDetectCommand();
[[nodiscard]] std::unique_ptr<Command> makeCalibrateCommand();
[[nodiscard]] std::unique_ptr<Command> makeProjectCommand();
[[nodiscard]] std::unique_ptr<Command> makeUnprojectCommand();
[[nodiscard]] std::unique_ptr<Command> makeUndistortCommand();
[[nodiscard]] std::unique_ptr<Command> makeValidateCommand();
[[nodiscard]] std::unique_ptr<Command> makeDiffCommand();
[[nodiscard]] std::unique_ptr<Command> makeConvertCommand();
[[nodiscard]] std::unique_ptr<Command> makeSimulateCommand();

/// The flags --json, --quiet, --config, and --jobs where a command has work to share out.
void addCommonOptions(CLI::App& app, CommonOptions& options, bool has_jobs);

/// The flag --board. A SPEC that is wrong is refused where it was given, on the command line or in a settings
/// file.
void addBoardOption(CLI::App& app, std::string& board);

/// "alidade 0.1.0"
[[nodiscard]] std::string programName();

/// A document as text. Names of files may be anything; bytes that are not UTF-8 become U+FFFD.
[[nodiscard]] std::string jsonText(const nlohmann::json& document);

/// JSON has no number for what is not finite: null.
[[nodiscard]] nlohmann::json orNull(double value);

/// The exit code where the work is done and the answer is no.
inline constexpr int kUntrustworthyExit = static_cast<int>(ErrorCode::kVerdict);

/// `inputs` and the images that they stand for. Without the images if the inputs are at fault: reading them
/// says how.
[[nodiscard]] std::vector<std::string> withImages(std::vector<std::string> inputs);

/// Checks before any long work that its result can go where `output` says (nothing: nowhere; "-": standard
/// output, which --json has for itself), and would overwrite none of the `sources`. These may be anything
/// that was given; what is not the path of a file is left aside. `flag` is where `output` comes from.
/// @throws Error (kUsage, kInput)
void checkOutput(const std::string& output, const std::vector<std::string>& sources,
                 const CommonOptions& options, const std::string& flag = "--output");

/// Writes a result to standard output and makes sure that it arrived. @throws Error when it did not (disk
/// full).
void printResult(std::string_view text);

/// Writes a message for people to standard error, with control characters as "\x1b".
void printMessage(const std::string& text);

}  // namespace alidade
