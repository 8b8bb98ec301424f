// SPDX-License-Identifier: MIT
// Sums of products of columns, in tiles that stay in registers; included by the source that holds the loops.
#pragma once

#include <cstddef>
#include <utility>

#include "alidade/core/lanes.h"

namespace alidade::detail {

/// Calls f(integral_constant<int, 0>) to f(... N - 1).
template <int kCount, class F>
ALIDADE_ALWAYS_INLINE void forEachIndex(const F& f) {
  [&]<int... kI>(std::integer_sequence<int, kI...>) ALIDADE_INLINE_LAMBDA {
    (f(std::integral_constant<int, kI>{}), ...);
  }
  (std::make_integer_sequence<int, kCount>{});
}

ALIDADE_ALWAYS_INLINE double sumOfLanes(const Lanes& lanes) {
#if defined(ALIDADE_HAS_VECTORS)
  return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
#else
  return lanes;
#endif
}

/// The sums over the lanes of kCount values; four at a time, they add up side by side.
template <int kCount>
ALIDADE_ALWAYS_INLINE void sumEach(const Lanes* from, double* to) {
#if defined(ALIDADE_HAS_VECTORS)
  constexpr int kWhole = kCount / 4 * 4;
  for (int i = 0; i < kWhole; i += 4) {
    const Lanes* f = from + i;
    const Lanes ab =
        __builtin_shufflevector(f[0], f[1], 0, 4, 2, 6) + __builtin_shufflevector(f[0], f[1], 1, 5, 3, 7);
    const Lanes cd =
        __builtin_shufflevector(f[2], f[3], 0, 4, 2, 6) + __builtin_shufflevector(f[2], f[3], 1, 5, 3, 7);
    lane::store(__builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7),
                to + i);
  }
#else
  constexpr int kWhole = 0;
#endif
  for (int i = kWhole; i < kCount; ++i) to[i] = sumOfLanes(from[i]);
}

/// put(i, j, sum over the rows of column i times column j) for kRows columns from `row` on and kColumns from
/// `column` on; where both are the same, for i <= j only. The rows are `stride` apart.
template <int kRow, int kRows, int kColumn, int kColumns, class Put>
ALIDADE_ALWAYS_INLINE void sumTile(const Lanes* rows, std::size_t num_rows, std::size_t stride,
                                   const Put& put) {
  constexpr bool kIsDiagonal = kRow == kColumn;
  Lanes sums[kRows][kColumns] = {};
  for (std::size_t n = 0; n < num_rows; ++n, rows += stride) {
    forEachIndex<kRows>([&](auto i) ALIDADE_INLINE_LAMBDA {
      forEachIndex<kColumns>([&](auto j) ALIDADE_INLINE_LAMBDA {
        if constexpr (!kIsDiagonal || i() <= j()) sums[i()][j()] += rows[kRow + i()] * rows[kColumn + j()];
      });
    });
  }
  double totals[kRows * kColumns];
  sumEach<kRows * kColumns>(&sums[0][0], totals);
  forEachIndex<kRows>([&](auto i) ALIDADE_INLINE_LAMBDA {
    forEachIndex<kColumns>([&](auto j) ALIDADE_INLINE_LAMBDA {
      if constexpr (!kIsDiagonal || i() <= j()) put(kRow + i(), kColumn + j(), totals[i() * kColumns + j()]);
    });
  });
}

}  // namespace alidade::detail
