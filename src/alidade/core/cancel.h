// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <exception>

namespace alidade {

/// Raised by a signal handler or another thread; long work looks at it between units. Lock-free, so a
/// signal handler may set it.
using CancelFlag = std::atomic<bool>;
static_assert(CancelFlag::is_always_lock_free);

/// Thrown by long work that found its CancelFlag raised. Not an Error: nothing was wrong with the input.
class Cancelled : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "cancelled"; }
};

inline void throwIfCancelled(const CancelFlag* cancel) {
  if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) throw Cancelled();
}

}  // namespace alidade
