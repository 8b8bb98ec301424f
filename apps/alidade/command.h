// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "alidade/core/error.h"
#include "flags.h"

namespace alidade {

/// The exit code where the work is done and the answer is no.
inline constexpr int kUntrustworthyExit = static_cast<int>(ErrorCode::kVerdict);

/// One command of the program: its flags, and what it does with them.
class Command {
 public:
  virtual ~Command() = default;
  virtual void setUp(Flags& flags) = 0;
  /// Does the work. @returns the exit code
  virtual int run(const Flags& flags) = 0;
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
[[nodiscard]] std::unique_ptr<Command> makeFleetCommand();
[[nodiscard]] std::unique_ptr<Command> makeConvertCommand();
[[nodiscard]] std::unique_ptr<Command> makeSimulateCommand();
[[nodiscard]] std::unique_ptr<Command> makeReportCommand();
[[nodiscard]] std::unique_ptr<Command> makeBoardCommand();
[[nodiscard]] std::unique_ptr<Command> makeTrackCommand();
[[nodiscard]] std::unique_ptr<Command> makeHelpCommand();
[[nodiscard]] std::unique_ptr<Command> makeRigCalibrateCommand();
[[nodiscard]] std::unique_ptr<Command> makeRigValidateCommand();
[[nodiscard]] std::unique_ptr<Command> makeRigTriangulateCommand();
[[nodiscard]] std::unique_ptr<Command> makeRigRectifyCommand();

/// The complaint about a command line without something that the command needs.
[[nodiscard]] Error missingError(const std::string& command, const std::string& found,
                                 const std::string& expected);

/// The complaint about images of which none is usable ("none of them can be read"), with the message of the
/// first one's error and its next step.
[[nodiscard]] Error noneUsableError(std::size_t num_images, const std::string& complaint,
                                    const std::string& first_error);

inline void append(std::vector<std::string>& list, const std::vector<std::string>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

}  // namespace alidade
