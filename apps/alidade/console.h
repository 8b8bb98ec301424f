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

/// Writes a result to standard output and makes sure that it arrived. @throws Error when it did not (disk
/// full).
void printResult(std::string_view text);

/// From now on only this program's own messages reach standard error: libraries that write there say nothing
/// that a user could use, such as which file they mean.
void silenceLibraries();

/// Where messages go instead of standard error; the stream must outlive them.
void sendMessagesTo(std::FILE* stream);

/// Writes a message for people to standard error, with control characters as "\x1b". A line ends where the
/// next one is indented.
void printMessage(const std::string& text);
/// The same with text of this program alone, as it is.
void printHelp(std::string_view text);

/// `text` with control characters and bytes that are not UTF-8 as "\x1b". File names may contain both: they
/// would change the terminal, forge a line of a table, or make XML invalid.
[[nodiscard]] std::string printable(std::string_view text);

/// A message for each note: "note: ...".
void printNotes(const std::vector<std::string>& notes);

/// The first dozen of these lines, indented, and how many more there are; with a line end each.
[[nodiscard]] std::string listed(const std::vector<std::string>& lines);
/// The same as a message, behind a title of its own line if there is one. Nothing without lines.
void printListed(const std::vector<std::string>& lines, const std::string& title = "");

/// A bar on standard error if that is a terminal, silence otherwise. Wiped when it ends.
class ProgressBar {
 public:
  ProgressBar(std::string label, bool is_quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Draws at most ten times a second. Not for several threads at once.
  void update(std::size_t done, std::size_t total);
  /// update() as functions that report their progress take it; not to outlive the bar.
  [[nodiscard]] auto reporter() {
    return [this](std::size_t done, std::size_t total) { update(done, total); };
  }

 private:
  std::string label_;
  bool is_shown_;
  bool has_drawn_ = false;
  std::chrono::steady_clock::time_point last_draw_;
};

/// From now on the first Ctrl-C (or SIGTERM, SIGHUP) raises the flag instead of ending the program; a second
/// one ends it. Signals that the caller had ignored, as nohup does, stay ignored.
[[nodiscard]] const CancelFlag* catchInterrupts();

/// Ends the program by the signal that was caught, as callers such as shells expect of an interrupted
/// program.
[[noreturn]] void endByCaughtSignal();

}  // namespace alidade
