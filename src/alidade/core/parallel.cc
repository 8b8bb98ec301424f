// SPDX-License-Identifier: MIT
#include "alidade/core/parallel.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace alidade {

int resolveJobs(int num_jobs) {
  if (num_jobs > 0) return num_jobs;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallelFor(std::size_t count, int num_jobs, const std::function<void(std::size_t)>& work,
                 const CancelFlag* cancel) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr error;
  std::size_t error_index = count;

  // Indices are handed out in rising order, so every index below a failing one has been started and will
  // finish. The smallest failing index is therefore always seen, regardless of timing.
  const auto run = [&] {
    for (;;) {
      if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return;
      const std::size_t i = next.fetch_add(1);
      if (i >= count) return;
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (i < error_index) {
          error_index = i;
          error = std::current_exception();
        }
        next.store(count);
        return;
      }
    }
  };

  const auto num_threads = std::min(count, static_cast<std::size_t>(resolveJobs(num_jobs)));
  std::vector<std::jthread> threads;
  try {
    for (std::size_t t = 1; t < num_threads; ++t) threads.emplace_back(run);
  } catch (const std::system_error&) {
    // No more threads are available; continue with those already running.
  }
  run();
  threads.clear();
  throwIfCancelled(cancel);
  if (error) std::rethrow_exception(error);
}

}  // namespace alidade
