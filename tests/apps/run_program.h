// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <iosfwd>
#include <string>
#include <vector>

#include <sys/types.h>

namespace alidade {

/// How a program is run, beside its arguments.
struct RunOptions {
  std::string input{};        ///< text for standard input
  std::string input_path{};   ///< a file for standard input instead of the text
  std::string output_path{};  ///< a file for standard output, which is not captured then
  std::string folder{};       ///< working directory; empty = this one
  std::chrono::seconds time_limit{60};
};

/// What a program did.
struct RunResult {
  int exit_code = -1;    ///< -1 if a signal ended it
  int signal = 0;        ///< which one; 0 if none
  bool is_late = false;  ///< it was killed at the time limit
  std::string out;
  std::string err;
};

/// For the messages of failed tests.
void PrintTo(const RunResult& result, std::ostream* out);

/// A program while it runs. No shell is involved; signals that this process ignores are not ignored there.
class RunningProgram {
 public:
  /// @throws std::runtime_error if it cannot be started
  RunningProgram(const std::string& program, const std::vector<std::string>& args, RunOptions options = {});
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  void sendSignal(int signal) const;
  /// Waits until the program has a handler for the signal. @returns false if it ends or has none in time
  [[nodiscard]] bool waitUntilItCatches(int signal) const;
  /// Reads no more of the program's standard output, as `| head` does.
  void closeOutput();
  /// Feeds and reads the program until it ends. Once only.
  [[nodiscard]] RunResult wait();

 private:
  void exchange(RunResult& result);

  RunOptions options_;
  std::chrono::steady_clock::time_point deadline_;
  pid_t pid_ = -1;
  int in_ = -1;
  int out_ = -1;
  int err_ = -1;
};

/// Runs a program to its end.
[[nodiscard]] RunResult runProgram(const std::string& program, const std::vector<std::string>& args,
                                   RunOptions options = {});

}  // namespace alidade
