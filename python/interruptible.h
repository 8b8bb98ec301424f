// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>

#include <pybind11/pybind11.h>

#include "alidade/core/cancel.h"

namespace alidade::python {

/// (done, total) of a stage of the work; from any thread.
using ReportProgress = std::function<void(const char* stage, std::size_t done, std::size_t total)>;

/// Runs long work on a thread of its own, without the interpreter lock. Meanwhile the calling thread handles
/// Python's signals, so that Ctrl-C cancels the work, and calls `progress` (None: nobody) with (stage, done,
/// total). A stage's last report always arrives; of the others as many as the callback is fast enough for.
/// @throws what the work throws; the exception of the callback or of the signal's handler, once the work has
/// stopped
void runInterruptibly(const pybind11::object& progress,
                      const std::function<void(const CancelFlag*, const ReportProgress&)>& work);

}  // namespace alidade::python
