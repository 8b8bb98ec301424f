// SPDX-License-Identifier: MIT
#include "progress.h"

#include <unistd.h>
#include <cstdio>

#include <fmt/format.h>

namespace alidade {

ProgressBar::ProgressBar(std::string label, bool is_quiet)
    : label_(std::move(label)), is_shown_(!is_quiet && isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (has_drawn_) std::fputs("\r\033[K", stderr);
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
  fmt::print(stderr, "\r{} [{}] {}/{}\033[K", label_, bar, done, total);
  std::fflush(stderr);
}

}  // namespace alidade
