// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>

#include <pybind11/pybind11.h>

#include "alidade/core/cancel.h"

namespace alidade::python {

/// (done, total) of a stage of the work; called from any thread.
using ReportProgress = std::function<void(const char* stage, std::size_t done, std::size_t total)>;

/// Runs long work on a separate thread, without the interpreter lock. Meanwhile the calling thread handles
/// Python's signals, so that Ctrl-C cancels the work, and calls `progress` (may be None) with (stage, done,
/// total). A stage's last report always arrives; others are dropped if the callback is slow.
/// @throws exceptions of the work, or of the callback or signal handler once the work has stopped
void runInterruptibly(const pybind11::object& progress,
                      const std::function<void(const CancelFlag*, const ReportProgress&)>& work);

}  // namespace alidade::python
