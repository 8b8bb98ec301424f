// SPDX-License-Identifier: MIT
#include "console.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>
#include <boost/locale/utf.hpp>

#include "alidade/core/error.h"

namespace alidade {
namespace {

FILE* messages = nullptr;  // standard error, until sendMessagesTo()
FILE* messageStream() {
  return messages != nullptr ? messages : stderr;
}

CancelFlag cancel_requested{false};
volatile std::sig_atomic_t caught_signal = SIGINT;

extern "C" void onSignal(int signal) {
  caught_signal = signal;
  cancel_requested.store(true, std::memory_order_relaxed);
}

}  // namespace

std::string programName() {
  return "alidade " ALIDADE_VERSION;
}

void printResult(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return;
  throw inputError(
      {.where = "standard output",
       .found = std::strerror(errno),
       .next_step = "free some space, or redirect the output; files that were to be written are complete"});
}

void silenceLibraries() {
#ifndef __SANITIZE_ADDRESS__  // AddressSanitizer reports there
  const int own = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int nothing = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  FILE* const stream = own >= 0 && nothing >= 0 ? ::fdopen(own, "w") : nullptr;
  if (stream != nullptr && ::dup2(nothing, STDERR_FILENO) >= 0) {
    std::setvbuf(stream, nullptr, _IONBF, 0);
    sendMessagesTo(stream);
  }
  if (nothing > STDERR_FILENO) ::close(nothing);
#endif
}

void sendMessagesTo(std::FILE* stream) {
  messages = stream;
}

void printMessage(const std::string& text) {
  std::string message;
  std::string_view rest = text;
  while (true) {
    const std::size_t end = rest.find("\n ");
    message += printable(rest.substr(0, end)) + "\n";
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  printHelp(message);
}

void printHelp(std::string_view text) {
  static_cast<void>(std::fwrite(text.data(), 1, text.size(), messageStream()));
}

std::string printable(std::string_view text) {
  using Utf8 = boost::locale::utf::utf_traits<char>;
  std::string result;
  while (!text.empty()) {
    const char* next = text.data();
    const auto point = Utf8::decode(next, text.data() + text.size());
    // Includes two code points that XML does not allow.
    const bool is_control =
        point < 0x20 || (point >= 0x7f && point < 0xa0) || point == 0xfffe || point == 0xffff;
    const bool is_good = boost::locale::utf::is_valid_codepoint(point) && !is_control;
    const std::size_t size = is_good ? static_cast<std::size_t>(next - text.data()) : 1;
    result += is_good ? std::string(text.substr(0, size))
                      : fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
    text.remove_prefix(size);
  }
  return result;
}

std::string listed(const std::vector<std::string>& lines) {
  constexpr std::size_t kMost = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(lines.size(), kMost); ++i) text += "  " + lines[i] + "\n";
  if (lines.size() > kMost) text += fmt::format("  ... and {} more\n", lines.size() - kMost);
  return text;
}

void printNotes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) printMessage("note: " + note);
}

void printListed(const std::vector<std::string>& lines, const std::string& title) {
  if (lines.empty()) return;
  const std::string text = (title.empty() ? "" : title + "\n") + listed(lines);
  printMessage(text.substr(0, text.size() - 1));
}

ProgressBar::ProgressBar(std::string label, bool is_quiet)
    : label_(std::move(label)), is_shown_(!is_quiet && isatty(fileno(messageStream())) == 1) {}

ProgressBar::~ProgressBar() {
  if (has_drawn_) std::fputs("\r\033[K", messageStream());
}

void ProgressBar::update(std::size_t done, std::size_t total) {
  if (!is_shown_ || total == 0) return;
  const auto now = std::chrono::steady_clock::now();
  if (has_drawn_ && done < total && now - last_draw_ < std::chrono::milliseconds(100)) return;
  last_draw_ = now;
  has_drawn_ = true;
  constexpr std::size_t kWidth = 30;
  const std::size_t filled = kWidth * done / total;
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  // The first seconds tell too little.
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double left =
      done == 0 || seconds < 2 ? 0 : seconds * static_cast<double>(total - done) / static_cast<double>(done);
  const std::string remaining = left < 1    ? ""
                                : left < 90 ? fmt::format(", {:.0f} s left", left)
                                            : fmt::format(", {:.0f} min left", left / 60);
  fmt::print(messageStream(), "\r{} [{}] {}/{}{}\033[K", label_, bar, done, total, remaining);
  std::fflush(messageStream());
}

const CancelFlag* catchInterrupts() {
  struct sigaction action {};
  action.sa_handler = onSignal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second signal has its default effect
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
  return &cancel_requested;
}

void endByCaughtSignal() {
  std::signal(caught_signal, SIG_DFL);
  std::raise(caught_signal);
  constexpr int kSignalExit = 128;  // like a shell; the first process of a container survives its signals
  ::_exit(kSignalExit + caught_signal);
}

}  // namespace alidade
