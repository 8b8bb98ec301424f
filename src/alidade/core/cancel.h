// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <exception>

namespace alidade {

/// Set by a signal handler or another thread. Long work checks it between units. It is lock-free, so a signal
/// handler may set it.
using CancelFlag = std::atomic<bool>;
static_assert(CancelFlag::is_always_lock_free);

/// Thrown by long work when its CancelFlag is set. It is not an Error, because the input is not at fault.
class Cancelled : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "cancelled"; }
};

inline void throwIfCancelled(const CancelFlag* cancel) {
  if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) throw Cancelled();
}

}  // namespace alidade
