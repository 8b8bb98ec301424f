// SPDX-License-Identifier: MIT
// Sums of a view's normal equations, for inclusion in the source that holds the loops.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>

#include "alidade/adjust/board/elimination.h"
#include "alidade/adjust/board/view_rows.h"
#include "alidade/core/lanes.h"

namespace alidade::detail {

/// Calls f(integral_constant<int, 0>) to f(integral_constant<int, kCount - 1>).
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

/// Sums of kCount values over their lanes; four sums at a time are computed in parallel.
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

/// Adds to the upper triangle, over rows that are `stride` apart, the products of kRows columns from `a` on
/// and kColumns from `b` on; if both are the same, only for i <= j. `to_a` and `to_b` are their columns in
/// the result.
template <int kRows, int kColumns, bool kIsDiagonal>
ALIDADE_ALWAYS_INLINE void addTile(const Lanes* a, const Lanes* b, std::size_t num_rows, std::size_t stride,
                                   const std::size_t* to_a, const std::size_t* to_b,
                                   EliminationEquations& to) {
  Lanes sums[kRows][kColumns] = {};
  for (std::size_t n = 0; n < num_rows; ++n, a += stride, b += stride) {
    forEachIndex<kRows>([&](auto i) ALIDADE_INLINE_LAMBDA {
      forEachIndex<kColumns>([&](auto j) ALIDADE_INLINE_LAMBDA {
        if constexpr (!kIsDiagonal || i() <= j()) sums[i()][j()] += a[i()] * b[j()];
      });
    });
  }
  double totals[kRows * kColumns];
  sumEach<kRows * kColumns>(&sums[0][0], totals);
  forEachIndex<kRows>([&](auto i) ALIDADE_INLINE_LAMBDA {
    forEachIndex<kColumns>([&](auto j) ALIDADE_INLINE_LAMBDA {
      if constexpr (!kIsDiagonal || i() <= j())
        to.at(std::min(to_a[i()], to_b[j()]), std::max(to_a[i()], to_b[j()])) += totals[i() * kColumns + j()];
    });
  });
}

inline constexpr std::size_t kTile = 3;  // nine sums and their operands fit into sixteen registers

/// The same for sizes known only at run time: at most kTile columns of each.
template <int kRows>
ALIDADE_ALWAYS_INLINE void addTileOf(std::size_t num_columns, const Lanes* a, const Lanes* b,
                                     std::size_t num_rows, std::size_t stride, const std::size_t* to_a,
                                     const std::size_t* to_b, EliminationEquations& to) {
  if (a == b) return addTile<kRows, kRows, true>(a, b, num_rows, stride, to_a, to_b, to);
  if (num_columns == 3) return addTile<kRows, 3, false>(a, b, num_rows, stride, to_a, to_b, to);
  if (num_columns == 2) return addTile<kRows, 2, false>(a, b, num_rows, stride, to_a, to_b, to);
  addTile<kRows, 1, false>(a, b, num_rows, stride, to_a, to_b, to);
}

/// Adds the products of all columns of the alternating rows of u and v, of `num_groups` groups. Only shared
/// columns are in all rows; a column of one axis is multiplied only with columns in rows of the same axis.
ALIDADE_ALWAYS_INLINE void addProducts(const RowLayout& of, const Lanes* all_rows, std::size_t num_groups,
                                       EliminationEquations& to) {
  for (const std::size_t part : {0U, 1U, 2U}) {  // the shared columns, then those of u and of v
    const std::size_t axis = part == 2 ? 1 : 0;
    const std::size_t* columns = of.column[axis].data();
    const Lanes* rows = all_rows + axis * of.width;
    const std::size_t num_rows = part == 0 ? 2 * num_groups : num_groups;
    const std::size_t stride = part == 0 ? of.width : 2 * of.width;
    const std::size_t end = part == 0 ? of.num_shared : of.width;
    std::size_t num_a = 0;
    for (std::size_t a = 0; a < end; a += num_a) {
      num_a = std::min(kTile, (a < of.num_shared ? of.num_shared : end) - a);
      for (std::size_t b = part == 0 ? a : of.num_shared; b < end; b += kTile) {
        const auto add = [&]<int kRows>() ALIDADE_INLINE_LAMBDA {
          addTileOf<kRows>(end - b < kTile ? end - b : kTile, rows + a, rows + b, num_rows, stride,
                           columns + a, columns + b, to);
        };
        if (num_a == 3) {
          add.template operator()<3>();
        } else if (num_a == 2) {
          add.template operator()<2>();
        } else {
          add.template operator()<1>();
        }
      }
    }
  }
}

}  // namespace alidade::detail
