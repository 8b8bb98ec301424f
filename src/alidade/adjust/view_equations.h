// SPDX-License-Identifier: MIT
// The normal equations of a view; included by the sources that hold the loops.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "alidade/adjust/elimination.h"
#include "alidade/adjust/gram_tiles.h"
#include "alidade/adjust/view_kernel.h"
#include "alidade/adjust/view_rows.h"

namespace alidade::detail {

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
