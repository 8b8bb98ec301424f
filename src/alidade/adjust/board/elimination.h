// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

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

/// Room for the pose, kMostParams parameters and the error, in whole lanes.
inline constexpr std::size_t kMaxColumns = 40;

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

}  // namespace alidade::detail
