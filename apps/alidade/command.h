// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
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
  [[nodiscard]] virtual bool owesJson() const { return common_.json && !has_answered_; }
  /// Writes the JUnit report of an input error, so that none of an earlier run remains.
  void writeJunitError(const std::string& message) const;

 protected:
  using Answer = std::function<std::string()>;
  /// Prints the document with --json, or else the text unless --quiet.
  void answer(const Answer& document, const Answer& text);
  /// The error for a command line that lacks something required.
  [[nodiscard]] Error missing(const std::string& found, const std::string& expected) const;
  /// The error for flags and inputs that cannot be combined.
  [[nodiscard]] Error misuse(const std::string& found, const std::string& expected,
                             const std::string& next_step = "") const;
  /// The origin that files state: "alidade 0.1.0 undistort".
  [[nodiscard]] std::string maker() const;

  CommonOptions common_;

 private:
  bool has_answered_ = false;
};

/// A command in the program's list.
struct CommandEntry {
  const char* name;  ///< "detect"; including its group: "rig calibrate"
  const char* summary;
  std::unique_ptr<Command> (*make)();
};
template <class Kind>
std::unique_ptr<Command> made() {
  return std::make_unique<Kind>();
}

extern const CommandEntry kCalibrateCommand;
extern const CommandEntry kDetectCommand;
extern const CommandEntry kRigCalibrateCommand;
extern const CommandEntry kRigValidateCommand;
extern const CommandEntry kRigRectifyCommand;
extern const CommandEntry kRigTriangulateCommand;
extern const CommandEntry kHandEyeCalibrateCommand;
extern const CommandEntry kHandEyeValidateCommand;
extern const CommandEntry kProjectCommand;
extern const CommandEntry kUnprojectCommand;
extern const CommandEntry kPoseCommand;
extern const CommandEntry kUndistortCommand;
extern const CommandEntry kValidateCommand;
extern const CommandEntry kDiffCommand;
extern const CommandEntry kFleetCommand;
extern const CommandEntry kConvertCommand;
extern const CommandEntry kFormatsCommand;
extern const CommandEntry kReportCommand;
extern const CommandEntry kTrackCommand;
extern const CommandEntry kBoardCommand;
extern const CommandEntry kSimulateCommand;
extern const CommandEntry kHelpCommand;

/// The error for a flag, a flag and its value, or the arguments of a command that cannot be used as given.
[[nodiscard]] Error flagError(const std::string& flag, const std::string& found, const std::string& expected,
                              const std::string& next_step = "");

/// The error for images of which none is usable ("none of them can be read"), with the first one's error
/// message and its next step.
[[nodiscard]] Error noneUsableError(std::size_t num_images, const std::string& complaint,
                                    const std::string& first_error);

inline void append(std::vector<std::string>& list, const std::vector<std::string>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

}  // namespace alidade
