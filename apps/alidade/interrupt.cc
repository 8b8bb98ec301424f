// SPDX-License-Identifier: MIT
#include "interrupt.h"

#include <csignal>
#include <cstdlib>

namespace alidade {
namespace {

CancelFlag cancel_requested{false};
volatile std::sig_atomic_t caught_signal = SIGINT;

extern "C" void onSignal(int signal) {
  caught_signal = signal;
  cancel_requested.store(true, std::memory_order_relaxed);
}

}  // namespace

const CancelFlag* catchInterrupts() {
  struct sigaction action {};
  action.sa_handler = onSignal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // the second one takes its usual course
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
  std::abort();
}

}  // namespace alidade
