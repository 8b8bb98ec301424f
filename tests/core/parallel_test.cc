// SPDX-License-Identifier: MIT
#include "alidade/core/parallel.h"

#include <gmock/gmock.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace alidade {
namespace {

TEST(ParallelFor, CallsEveryIndexOnce) {
  for (const int jobs : {1, 2, 8}) {
    std::vector<int> calls(1000, 0);
    parallelFor(calls.size(), jobs, [&](std::size_t i) { ++calls[i]; });
    EXPECT_THAT(calls, testing::Each(1)) << jobs << " jobs";
  }
}

TEST(ParallelFor, AcceptsNothingToDo) {
  parallelFor(0, 4, [](std::size_t) { FAIL(); });
}

TEST(ParallelFor, RethrowsTheFirstFailureForAnyNumberOfThreads) {
  for (const int jobs : {1, 2, 8}) {
    std::string message;
    try {
      parallelFor(500, jobs, [](std::size_t i) {
        if (i >= 100) throw std::runtime_error(std::to_string(i));
      });
    } catch (const std::runtime_error& error) {
      message = error.what();
    }
    EXPECT_EQ(message, "100") << jobs << " jobs";
  }
}

TEST(ParallelFor, StopsWhenCancelled) {
  CancelFlag cancel{false};
  std::atomic<int> calls{0};
  EXPECT_THROW(parallelFor(
                   1000, 2,
                   [&](std::size_t) {
                     if (++calls == 10) cancel = true;
                   },
                   &cancel),
               Cancelled);
  EXPECT_LT(calls, 1000);
}

}  // namespace
}  // namespace alidade
