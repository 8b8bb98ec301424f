// SPDX-License-Identifier: MIT
// What the loops over many points share; included by the sources that hold them and by nothing else.
#pragma once

#include <cstddef>
#include <limits>

#include "alidade/core/lanes.h"

namespace alidade::batch {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Whether the loops use AVX2; a test may turn it off.
inline bool& usesAvx2() {
  static bool uses = hasAvx2();
  return uses;
}

ALIDADE_ALWAYS_INLINE bool laneOf(const LaneMask& mask, std::size_t l) {
#if defined(ALIDADE_HAS_VECTORS)
  return mask[l] != 0;
#else
  return l == 0 && mask;
#endif
}

/// Writes row-major Jacobians of kSize numbers, one lane's after another's, plus `nothing`: 0, or NaN in
/// lanes that have none.
template <int kSize>
ALIDADE_ALWAYS_INLINE void scatter(const Lanes* from, const Lanes& nothing, double* to) {
  for (int e = 0; e < kSize; ++e) {
    double values[kNumLanes];
    lane::store(from[e] + nothing, values);
    for (std::size_t l = 0; l < kNumLanes; ++l) to[l * kSize + static_cast<std::size_t>(e)] = values[l];
  }
}

/// The last points of a batch, fewer than there are lanes, are copied to arrays of full length and back.
template <class T>
class Padded {
 public:
  Padded(const T* from, std::size_t count, T filler) {
    for (std::size_t l = 0; l < kNumLanes; ++l) values_[l] = l < count ? from[l] : filler;
  }
  [[nodiscard]] const T* data() const { return values_; }

 private:
  T values_[kNumLanes];
};

}  // namespace alidade::batch
