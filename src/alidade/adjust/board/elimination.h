// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "alidade/core/lanes.h"

namespace alidade::detail {

// As in lanes.h: no vector is passed by a call that is left.
#if defined(ALIDADE_HAS_VECTORS)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

/// Pivots that have sunk below this share of their diagonal are rounding: several units of a sum over many
/// corners.
inline constexpr double kMinPivot = 1e-14;

inline constexpr std::size_t kMaxColumns = 64;

/// Normal equations [J r]^T [J r] of up to kMaxColumns columns, of which the last belongs to r: symmetric,
/// with rows that are filled up to whole lanes.
template <std::size_t kSize>
class EliminationEquations {
 public:
  static_assert(kSize <= kMaxColumns);
  static constexpr std::size_t kStride = (kSize + kNumLanes - 1) / kNumLanes * kNumLanes;

  ALIDADE_ALWAYS_INLINE double& at(std::size_t i, std::size_t j) { return elements_[i * kStride + j]; }
  [[nodiscard]] ALIDADE_ALWAYS_INLINE double at(std::size_t i, std::size_t j) const {
    return elements_[i * kStride + j];
  }

  /// Eliminates the columns from kFrom up to kTo, those before being eliminated already. Leaves their Schur
  /// complement in the columns from kTo on (upper triangle only) and writes one row of Cholesky's factor for
  /// each to `rows`, kSize numbers every `stride`: R^T R and the Schur complement make up what was there
  /// before.
  ///
  /// Pivots fall, relative to `diagonal`, the columns' sums of squares before anything was eliminated. So
  /// those that have sunk into rounding, because other columns determine theirs, come where nothing but
  /// rounding is left to divide by them, and many of them do no harm. Each is replaced by a tiny positive
  /// one, which keeps R^T times the last column exact where dropping the row would not.
  template <std::size_t kFrom, std::size_t kTo>
  ALIDADE_ALWAYS_INLINE void eliminate(const std::array<double, kSize>& diagonal, double* rows,
                                       std::size_t stride) {
    constexpr std::size_t kLast = kSize - 1;
    std::array<bool, kTo> is_done{};
    std::array<double, kTo> inverse_diagonal{};
    for (std::size_t j = kFrom; j < kTo; ++j) inverse_diagonal[j] = diagonal[j] > 0 ? 1 / diagonal[j] : 0.0;
    for (std::size_t row = 0; row < kTo - kFrom; ++row, rows += stride) {
      std::size_t k = kTo;
      double largest = 0;
      for (std::size_t j = kFrom; j < kTo; ++j) {
        const double share = at(j, j) * inverse_diagonal[j];
        if (is_done[j] || (k != kTo && share <= largest)) continue;
        k = j;
        largest = share;
      }
      is_done[k] = true;
      std::array<double, kStride> factor{};
      if (largest > kMinPivot) {
        const double inverse = 1 / std::sqrt(at(k, k));
        for (std::size_t j = kFrom; j < kSize; ++j) factor[j] = at(k, j) * inverse;
        for (std::size_t j = kFrom; j < kTo; ++j) {
          if (is_done[j] && j != k) factor[j] = 0;
        }
        for (std::size_t i = kFrom; i < kSize; ++i) {
          if (i < kTo && is_done[i]) continue;
          // The pivot's row is read whole, the others from their diagonal on.
          const std::size_t first = i < kTo ? kFrom : i;
          subtract(factor, factor[i], first / kNumLanes * kNumLanes, i);
        }
      } else {
        const double root = std::sqrt(kMinPivot * std::max(diagonal[k], 0.0));
        factor[k] = root;
        factor[kLast] = root > 0 ? at(k, kLast) / root : 0.0;
        at(kLast, kLast) -= factor[kLast] * factor[kLast];
      }
      std::copy_n(factor.begin(), kSize, rows);
    }
  }

 private:
  // Row i less f times the factor. In lanes, as a compiler left to itself turns the matrix about.
  ALIDADE_ALWAYS_INLINE void subtract(const std::array<double, kStride>& factor, double f, std::size_t first,
                                      std::size_t i) {
    double* row = elements_.data() + i * kStride;
    for (std::size_t j = first; j < kStride; j += kNumLanes)
      lane::store(lane::load(row + j) - f * lane::load(factor.data() + j), row + j);
  }

  alignas(Lanes) std::array<double, kSize * kStride> elements_{};
};

#if defined(ALIDADE_HAS_VECTORS)
#pragma GCC diagnostic pop
#endif

}  // namespace alidade::detail
