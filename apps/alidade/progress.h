// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace alidade {

/// A bar on standard error if that is a terminal, silence otherwise. Wiped when it ends.
class ProgressBar {
 public:
  ProgressBar(std::string label, bool is_quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Draws at most ten times a second. Not for several threads at once.
  void update(std::size_t done, std::size_t total);

 private:
  std::string label_;
  bool is_shown_;
  bool has_drawn_ = false;
  std::chrono::steady_clock::time_point last_draw_;
};

}  // namespace alidade
