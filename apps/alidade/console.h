// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/cancel.h"

namespace alidade {

/// "alidade 0.1.0"
[[nodiscard]] std::string programName();

/// Writes a result to standard output and checks that it arrived. @throws Error if not (disk full)
void printResult(std::string_view text);

/// Reserves standard error for this program's own messages: those of libraries do not help users, as they do
/// not even name a file.
void silenceLibraries();

/// Redirects messages from standard error to a stream, which must outlive them.
void sendMessagesTo(std::FILE* stream);

/// Writes a message for people to standard error, with control characters as "\x1b". Only
/// line breaks before an indented line are kept.
void printMessage(const std::string& text);
/// The same for text of this program only, unchanged.
void printHelp(std::string_view text);

/// `text` with control characters and bytes that are not UTF-8 as "\x1b". File names may contain both: they
/// would change the terminal, forge a line of a table, or make XML invalid.
[[nodiscard]] std::string printable(std::string_view text);

/// Prints one message per note: "note: ...".
void printNotes(const std::vector<std::string>& notes);

/// The first dozen of these lines, indented, and the number of others; each with a line end.
[[nodiscard]] std::string listed(const std::vector<std::string>& lines);
/// The same as a message, below a title if there is one. Prints nothing without lines.
void printListed(const std::vector<std::string>& lines, const std::string& title = "");

/// A progress bar with the remaining time on standard error if that is a terminal; otherwise nothing. Erased
/// at the end.
class ProgressBar {
 public:
  ProgressBar(std::string label, bool is_quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Draws at most ten times a second. Not thread-safe.
  void update(std::size_t done, std::size_t total);
  /// update() as a callback for functions that report progress; must not outlive the bar.
  [[nodiscard]] auto reporter() {
    return [this](std::size_t done, std::size_t total) { update(done, total); };
  }

 private:
  std::string label_;
  bool is_shown_;
  bool has_drawn_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_draw_;
};

/// Makes the first Ctrl-C (or SIGTERM, SIGHUP) raise the flag instead of ending the program; a second one
/// ends it. Signals that the caller ignores, as nohup does, stay ignored.
[[nodiscard]] const CancelFlag* catchInterrupts();

/// Ends the program by the caught signal, as shells and other callers expect of an interrupted program.
[[noreturn]] void endByCaughtSignal();

}  // namespace alidade
