// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "alidade/core/cancel.h"

namespace alidade {

/// Another program, while it runs. It has no input, inherits neither open files nor FFmpeg's variables for
/// messages, and is killed with the object.
class ChildProcess {
 public:
  /// Starts a program that is found in PATH. `max_bytes` limits its address space (Linux only).
  /// @throws std::system_error if it cannot be started
  ChildProcess(const std::vector<std::string>& command, std::size_t max_bytes);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits for output or messages. Appends what there is of its messages (standard error) to `messages`, and
  /// reads up to `size` bytes of its output (standard output) to `data`. Messages are never left unread, so
  /// the program cannot get stuck; output waits until it is asked for.
  /// @returns the bytes of output; 0 also if only messages came, or nothing is to come
  /// @throws Cancelled soon after the flag is set
  std::size_t read(char* data, std::size_t size, std::string& messages, const CancelFlag* cancel);

  [[nodiscard]] bool isOutputAtEnd() const { return out_ < 0; }
  [[nodiscard]] bool areMessagesAtEnd() const { return err_ < 0; }

  /// Waits for its end. @returns "" if it succeeded, or else how it ended: "status 1", "signal 9 (Killed)"
  [[nodiscard]] std::string failure();

 private:
  int pid_ = -1;
  int out_ = -1;  // -1 at its end
  int err_ = -1;
};

}  // namespace alidade
