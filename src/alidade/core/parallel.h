// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>

#include "alidade/core/cancel.h"

namespace alidade {

/// Calls `work(i)` for i in [0, count) on up to `num_jobs` threads (0: one per processor), in rising order of
/// start. Each call must write its result to its own slot, so that results do not depend on the number of
/// threads. If calls throw, the exception of the smallest index is rethrown after all running calls have
/// ended.
/// @throws Cancelled once `cancel` is set; no further index is started.
void parallelFor(std::size_t count, int num_jobs, const std::function<void(std::size_t)>& work,
                 const CancelFlag* cancel = nullptr);

/// The number of threads that `num_jobs` stands for: itself, or the number of processors for 0.
[[nodiscard]] int resolveJobs(int num_jobs);

}  // namespace alidade
