// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>

namespace alidade {

/// What kind of complaint an Error is; the value is the exit code of the command line program.
enum class ErrorCode {
  kInput = 1,    ///< a file, image or value from outside is unusable, or output cannot be written
  kUsage = 2,    ///< the caller asked for something that does not exist
  kVerdict = 3,  ///< the work was done and the answer is no
};

/// The four things a user needs to act on an error. Empty parts are left out of the message.
struct ErrorDetail {
  std::string where{};      ///< file and place in it: "cam.yaml:4: parameters.fx"
  std::string found{};      ///< what was there
  std::string expected{};   ///< what should have been there
  std::string next_step{};  ///< what to do about it
};

/// The one exception for bad input from outside. Numerical outcomes are fields of results instead.
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

/// Checks a precondition that only a bug of ours can break. Stays on in release builds.
/// @throws std::logic_error with `message`, which says what should have been true, when `condition` is false.
void expect(bool condition, const char* message);

}  // namespace alidade
