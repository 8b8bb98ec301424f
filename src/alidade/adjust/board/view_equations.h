// SPDX-License-Identifier: MIT
// The normal equations of a view; included by the sources that hold the loops.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "alidade/adjust/board/elimination.h"
#include "alidade/adjust/board/view_kernel.h"
#include "alidade/adjust/board/view_rows.h"
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

/// A view's normal equations: pose, parameters, error.
template <CameraModel M>
using ViewEquations = EliminationEquations<static_cast<std::size_t>(ViewRows<M>::kSize)>;

/// Adds the products of all columns of the rows of u and v, in turn, of `num_groups` groups. Only the shared
/// columns are in all rows.
template <CameraModel M>
class Products {
 public:
  ALIDADE_ALWAYS_INLINE static void add(const Lanes* rows, std::size_t num_groups, ViewEquations<M>& to) {
    constexpr int kStrips = (Rows::kShared + kTile - 1) / kTile;
    forEachIndex<kStrips>([&](auto a) ALIDADE_INLINE_LAMBDA {
      constexpr int kA = kTile * a();
      constexpr int kNumA = std::min(kTile, Rows::kShared - kA);
      forEachIndex<kStrips>([&](auto b) ALIDADE_INLINE_LAMBDA {
        constexpr int kB = kTile * b();
        constexpr int kNumB = std::min(kTile, Rows::kShared - kB);
        if constexpr (kB >= kA) {
          sumTile<kA, kNumA, kB, kNumB>(rows, 2 * num_groups, Rows::kWidth,
                                        [&](int i, int j, double sum)
                                            ALIDADE_INLINE_LAMBDA { put<0>(i, j, sum, to); });
        }
      });
      addOwn<kA, kNumA, 0>(rows, num_groups, to);
      addOwn<kA, kNumA, 1>(rows, num_groups, to);
    });
    addOwn<Rows::kShared, Rows::kOwn, 0>(rows, num_groups, to);
    addOwn<Rows::kShared, Rows::kOwn, 1>(rows, num_groups, to);
  }

 private:
  using Rows = ViewRows<M>;
  static constexpr int kTile = 3;  // nine sums and what they are made of fit sixteen registers

  template <int kA, int kNumA, int kAxis>
  ALIDADE_ALWAYS_INLINE static void addOwn(const Lanes* rows, std::size_t num_groups, ViewEquations<M>& to) {
    sumTile<kA, kNumA, Rows::kShared, Rows::kOwn>(rows + kAxis * Rows::kWidth, num_groups, 2 * Rows::kWidth,
                                                  [&](int i, int j, double sum)
                                                      ALIDADE_INLINE_LAMBDA { put<kAxis>(i, j, sum, to); });
  }

  template <int kAxis>
  ALIDADE_ALWAYS_INLINE static void put(int i, int j, double sum, ViewEquations<M>& to) {
    const int a = Rows::columnOf(kAxis, i);
    const int b = Rows::columnOf(kAxis, j);
    to.at(static_cast<std::size_t>(std::min(a, b)), static_cast<std::size_t>(std::max(a, b))) += sum;
  }
};

/// Sums the normal equations of a view, the upper triangle and the whole of the pose's rows, into `to`, which
/// starts at zero. The sum of rho stands in for r^T r. False with Unseen::kRefuse if a corner is not seen.
template <CameraModel M>
ALIDADE_ALWAYS_INLINE bool sumView(const ViewCamera<M>& camera, std::span<const CornerGroup> corners,
                                   HuberLoss loss, Unseen unseen, ViewEquations<M>& to) {
  using Rows = ViewRows<M>;
  constexpr std::size_t kChunk = 24;  // groups whose rows stay in the fastest cache
  constexpr auto kSize = static_cast<std::size_t>(Rows::kSize);
  constexpr auto kPose = static_cast<std::size_t>(Rows::kPose);
  const ViewCamera<M> local = camera;
  Lanes rows[kChunk * 2 * Rows::kWidth];
  Lanes sum_rho = {};
  for (std::size_t first = 0; first < corners.size(); first += kChunk) {
    const std::size_t count = std::min(kChunk, corners.size() - first);
    Lanes* row = rows;
    for (std::size_t i = 0; i < count; ++i, row += 2 * Rows::kWidth) {
      const bool is_seen = Rows::write(local, corners[first + i], loss, row, row + Rows::kWidth, sum_rho);
      if (!is_seen && unseen == Unseen::kRefuse) return false;
    }
    Products<M>::add(rows, count, to);
  }
  to.at(kSize - 1, kSize - 1) = sumOfLanes(sum_rho);
  for (std::size_t i = 0; i < kPose; ++i) {
    for (std::size_t j = 0; j < i; ++j) to.at(i, j) = to.at(j, i);
  }
  return true;
}

}  // namespace alidade::detail
