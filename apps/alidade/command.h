// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "alidade/core/error.h"
#include "flags.h"

namespace alidade {

/// The exit code if the work is done but the answer is no.
inline constexpr int kUntrustworthyExit = static_cast<int>(ErrorCode::kVerdict);

/// One command of the program: its flags and its action.
class Command {
 public:
  virtual ~Command() = default;
  virtual void setUp(Flags& flags) = 0;
  /// Does the work. @returns the exit code
  virtual int run(const Flags& flags) = 0;
  /// True if standard output still needs its JSON document, so that an error must be printed as one.
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

/// The error for a command line that lacks something required.
[[nodiscard]] Error missingError(const std::string& command, const std::string& found,
                                 const std::string& expected);

/// The error for images of which none is usable ("none of them can be read"), with the first one's error
/// message and its next step.
[[nodiscard]] Error noneUsableError(std::size_t num_images, const std::string& complaint,
                                    const std::string& first_error);

inline void append(std::vector<std::string>& list, const std::vector<std::string>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

}  // namespace alidade
