// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>

namespace alidade {

/// The kind of an Error. Its value is the exit code of the command line program.
enum class ErrorCode {
  kInput = 1,    ///< an input file, image or value is unusable, or output cannot be written
  kUsage = 2,    ///< the caller asked for something that does not exist
  kVerdict = 3,  ///< the work was done, and the result was rejected
};

/// Information that a user needs to act on an error. Empty parts do not appear in the message.
struct ErrorDetail {
  std::string where{};      ///< file and position: "cam.yaml:4: parameters.fx"
  std::string found{};      ///< what is wrong
  std::string expected{};   ///< what was expected instead
  std::string next_step{};  ///< what to do next
};

/// The only exception for bad input. Poor numerical results do not throw; they are fields of the result.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const ErrorDetail& detail);

  [[nodiscard]] ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

[[nodiscard]] inline Error inputError(const ErrorDetail& detail) {
  return {ErrorCode::kInput, detail};
}
[[nodiscard]] inline Error usageError(const ErrorDetail& detail) {
  return {ErrorCode::kUsage, detail};
}

/// Checks a precondition that only a bug can break. Active in release builds too.
/// @throws std::logic_error with `message`, which states the precondition, if `condition` is false.
void expect(bool condition, const char* message);

}  // namespace alidade
