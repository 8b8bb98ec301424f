// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

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

[[nodiscard]] std::unique_ptr<Command> makeDetectCommand();
[[nodiscard]] std::unique_ptr<Command> makeCalibrateCommand();
[[nodiscard]] std::unique_ptr<Command> makeProjectCommand();
[[nodiscard]] std::unique_ptr<Command> makeUnprojectCommand();
[[nodiscard]] std::unique_ptr<Command> makeUndistortCommand();
[[nodiscard]] std::unique_ptr<Command> makeValidateCommand();
[[nodiscard]] std::unique_ptr<Command> makeDiffCommand();
[[nodiscard]] std::unique_ptr<Command> makeConvertCommand();
[[nodiscard]] std::unique_ptr<Command> makeSimulateCommand();

/// The exit code where the work is done and the answer is no.
inline constexpr int kUntrustworthyExit = static_cast<int>(ErrorCode::kVerdict);

}  // namespace alidade
