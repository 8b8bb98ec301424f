// SPDX-License-Identifier: MIT
// Sums of a view's normal equations, for inclusion in the sources that hold the loops.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "alidade/adjust/board/corner_groups.h"
#include "alidade/adjust/board/observation.h"
#include "alidade/core/lanes.h"

namespace alidade::detail {

// Same as in lanes.h: vectors are passed only to inlined functions.
#if defined(ALIDADE_HAS_VECTORS)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

/// Pivots below this share of their diagonal are rounding: several units in the last place of a sum over many
/// corners.
inline constexpr double kMinPivot = 1e-14;

/// Normal equations [J r]^T [J r] of up to kMaxColumns columns, the last of which belongs to r: symmetric,
/// with rows padded to whole lanes.
class EliminationEquations {
 public:
  ALIDADE_ALWAYS_INLINE explicit EliminationEquations(std::size_t size)
      : size_(size), stride_((size + kNumLanes - 1) / kNumLanes * kNumLanes) {
    std::fill_n(elements_.begin(), size_ * stride_, 0.0);
  }

  ALIDADE_ALWAYS_INLINE double& at(std::size_t i, std::size_t j) { return elements_[i * stride_ + j]; }

  /// Copies the elements above the diagonal of rows and columns `from` to `to` below it.
  ALIDADE_ALWAYS_INLINE void mirror(std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      for (std::size_t j = from; j < i; ++j) at(i, j) = at(j, i);
    }
  }

  /// Eliminates the columns from `from` up to `to`; earlier ones must already be eliminated. Leaves their
  /// Schur complement in the columns from `to` on (upper triangle only) and writes one row of Cholesky's
  /// factor for each to `rows`, row by row: R^T R plus the Schur complement equals the previous matrix.
  ///
  /// Pivots are chosen in falling order relative to `diagonal`, the sums of squares of the columns before any
  /// elimination. Pivots lost to rounding, because their columns depend on others, therefore come last, where
  /// they can do no harm. Each is replaced by a tiny positive one, which keeps R^T times the last column
  /// exact where dropping the row would not.
  ALIDADE_ALWAYS_INLINE void eliminate(std::size_t from, std::size_t to, const double* diagonal,
                                       double* rows) {
    const std::size_t last = size_ - 1;
    const std::size_t stride = stride_;  // local, so that it is not read again after each write
    std::array<bool, kMaxColumns> is_done{};
    std::array<double, kMaxColumns> inverse_diagonal;
    for (std::size_t j = from; j < to; ++j) inverse_diagonal[j] = diagonal[j] > 0 ? 1 / diagonal[j] : 0.0;
    for (std::size_t row = from; row < to; ++row, rows += size_) {
      std::size_t k = to;
      double largest = 0;
      for (std::size_t j = from; j < to; ++j) {
        const double share = at(j, j) * inverse_diagonal[j];
        if (is_done[j] || (k != to && share <= largest)) continue;
        k = j;
        largest = share;
      }
      is_done[k] = true;
      alignas(Lanes) std::array<double, kMaxColumns> factor;
      if (largest > kMinPivot) {
        const double inverse = 1 / std::sqrt(at(k, k));
        for (std::size_t j = 0; j < stride; j += kNumLanes)
          lane::store(lane::load(&at(k, j)) * inverse, factor.data() + j);
        for (std::size_t j = 0; j < to; ++j) {
          if (j < from || (is_done[j] && j != k)) factor[j] = 0;
        }
        for (std::size_t i = from; i < size_; ++i) {
          if (i < to && is_done[i]) continue;
          // The whole row of the pivot is needed, and the others from their diagonal on.
          const std::size_t first = i < to ? from : i;
          subtract(factor, factor[i], first / kNumLanes * kNumLanes, stride, elements_.data() + i * stride);
        }
      } else {
        std::fill_n(factor.begin(), stride, 0.0);
        const double root = std::sqrt(kMinPivot * std::max(diagonal[k], 0.0));
        factor[k] = root;
        factor[last] = root > 0 ? at(k, last) / root : 0.0;
        at(last, last) -= factor[last] * factor[last];
      }
      std::copy_n(factor.begin(), size_, rows);
    }
  }

 private:
  // The row minus f times the factor. Written with lanes, because the compiler alone would transpose the
  // matrix.
  ALIDADE_ALWAYS_INLINE static void subtract(const std::array<double, kMaxColumns>& factor, double f,
                                             std::size_t first, std::size_t stride, double* row) {
    for (std::size_t j = first; j < stride; j += kNumLanes)
      lane::store(lane::load(row + j) - f * lane::load(factor.data() + j), row + j);
  }

  std::size_t size_;
  std::size_t stride_;
  alignas(Lanes) std::array<double, kMaxColumns * kMaxColumns> elements_;
};

#if defined(ALIDADE_HAS_VECTORS)
#pragma GCC diagnostic pop
#endif

/// Number of groups whose rows fit into the L1 cache, and the largest number of lanes in these rows.
inline constexpr std::size_t kChunk = 24;
inline constexpr std::size_t kMaxChunkRows = 2 * kChunk * kMaxColumns;

/// Calls f(chunk) for each chunk in order, until it returns false.
template <class F>
bool forEachChunk(std::span<const CornerGroup> corners, const F& f) {
  for (; corners.size() > kChunk; corners = corners.subspan(kChunk)) {
    if (!f(corners.first(kChunk))) return false;
  }
  return f(corners);
}

/// The loss and weights for a group's errors.
struct GroupLoss {
  ALIDADE_ALWAYS_INLINE GroupLoss(const Lanes* px, const CornerGroup& group, HuberLoss loss)
      : root(lane::load(group.root_weight.data())) {
    const Lanes s = root * root * (px[0] * px[0] + px[1] * px[1]);
    rho = s;
    const double threshold = loss.threshold_px;
    const LaneMask is_far = s > threshold * threshold;
    if (!lane::isAny(is_far)) return;
    // HuberLoss, in lanes.
    const Lanes length = lane::squareRoot(s);
    rho = lane::select(is_far, 2 * threshold * length - threshold * threshold, s);
    root = lane::select(is_far, root * lane::squareRoot(Lanes(threshold / length)), root);
  }
  Lanes root;  ///< square root of the weight times that of the loss weight
  Lanes rho;
};

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
