// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numbers>

#include "alidade/core/vector_code.h"

namespace alidade {

#if defined(ALIDADE_HAS_VECTORS)
/// Several doubles that are computed in parallel. GCC and Clang compile the operators to the instructions
/// that the surrounding function may use; other compilers get one lane. Formulas that take a type T work for
/// double, Lanes and automatic differentiation alike if they branch only by lane::select.
using Lanes = double __attribute__((vector_size(32)));
inline constexpr std::size_t kNumLanes = 4;
#else
using Lanes = double;
inline constexpr std::size_t kNumLanes = 1;
#endif

/// The result of a comparison of lanes.
using LaneMask = decltype(Lanes{} < Lanes{});

/// Functions for scalars and for lanes. All are inlined, so that they use the instructions of the calling
/// function.
namespace lane {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// a where the condition is true, b elsewhere; both are computed.
template <class T>
ALIDADE_ALWAYS_INLINE T select(bool condition, const T& a, const T& b) {
  return condition ? a : b;
}

ALIDADE_ALWAYS_INLINE bool both(bool a, bool b) {
  return a && b;
}

ALIDADE_ALWAYS_INLINE bool isAny(bool mask) {
  return mask;
}

ALIDADE_ALWAYS_INLINE bool isAll(bool mask) {
  return mask;
}

template <class T>
ALIDADE_ALWAYS_INLINE T squareRoot(const T& a) {
  using std::sqrt;
  return sqrt(a);
}

template <class T>
ALIDADE_ALWAYS_INLINE void sineCosine(const T& angle, T& sine, T& cosine) {
  using std::cos;
  using std::sin;
  sine = sin(angle);
  cosine = cos(angle);
}

#if defined(ALIDADE_HAS_VECTORS)
// GCC warns that passing vectors differs between instruction sets; these functions pass none, as they are
// inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
ALIDADE_ALWAYS_INLINE Lanes select(const LaneMask& condition, const Lanes& a, const Lanes& b) {
  return condition ? a : b;
}

ALIDADE_ALWAYS_INLINE LaneMask both(const LaneMask& a, const LaneMask& b) {
  return a & b;
}

template <>
ALIDADE_ALWAYS_INLINE Lanes squareRoot(const Lanes& a) {
  return Lanes{__builtin_sqrt(a[0]), __builtin_sqrt(a[1]), __builtin_sqrt(a[2]), __builtin_sqrt(a[3])};
}

/// atan2(y, x) / y for y > 0, to three units in the last place. The product of y and the larger of the two
/// must not overflow or vanish.
ALIDADE_ALWAYS_INLINE Lanes arcTangent2OverY(const Lanes& y, const Lanes& x) {
  constexpr double kTanPi8 = std::numbers::sqrt2 - 1;
  const Lanes ax = select(x < 0.0, -x, x);
  const LaneMask is_steep = y > ax;
  const Lanes low = select(is_steep, ax, y);
  const Lanes high = select(is_steep, y, ax);
  // atan(a) = pi/4 + atan((a - 1) / (a + 1)) leaves |t| <= tan(pi/8).
  const LaneMask is_large = low > kTanPi8 * high;
  const Lanes numerator = select(is_large, low - high, low);
  const Lanes denominator = select(is_large, low + high, high);
  const Lanes inverse = 1.0 / (denominator * y);  // one division for both quotients
  const Lanes t = numerator * (y * inverse);
  // (atan(t) / t - 1) / t^2 by a polynomial in t^2: Chebyshev fit on [0, tan(pi/8)^2] of relative error
  // 6e-18.
  const Lanes u = t * t;
  Lanes p = u * -1.91768871190474352e-02 + 3.92316582955750878e-02;
  p = u * p - 5.08544973793984070e-02;
  p = u * p + 5.85814891280212954e-02;
  p = u * p - 6.66451144738193918e-02;
  p = u * p + 7.69218319082608654e-02;
  p = u * p - 9.09090457812390118e-02;
  p = u * p + 1.11111110152563614e-01;
  p = u * p - 1.42857142846665425e-01;
  p = u * p + 1.99999999999955214e-01;
  p = u * p - 3.33333333333333315e-01;
  const Lanes rest = t + t * u * p;
  Lanes angle = select(is_large, rest + std::numbers::pi / 4, rest);
  angle = select(is_steep, std::numbers::pi / 2 - angle, angle);
  return select(x < 0.0, std::numbers::pi - angle, angle) * (denominator * inverse);
}

/// Sine and cosine of an angle in [0, pi], to two units in the last place.
template <>
ALIDADE_ALWAYS_INLINE void sineCosine(const Lanes& angle, Lanes& sine, Lanes& cosine) {
  constexpr double kHalfPiLow = 6.123233995736766e-17;  // low-order part of pi/2
  // The nearest multiple of a quarter turn (0, 1 or 2) and the remaining angle, at most pi/4.
  const LaneMask is_first = angle <= std::numbers::pi / 4;
  const LaneMask is_last = angle > 3 * std::numbers::pi / 4;
  const Lanes zero = {};
  const Lanes quarters = select(is_first, zero, select(is_last, zero + 2.0, zero + 1.0));
  const Lanes r = (angle - quarters * (std::numbers::pi / 2)) - quarters * kHalfPiLow;
  // Taylor series; the omitted terms are below 1e-18.
  const Lanes r2 = r * r;
  Lanes s = r2 * (1.0 / 355687428096000.0) - 1.0 / 1307674368000.0;
  s = r2 * s + 1.0 / 6227020800.0;
  s = r2 * s - 1.0 / 39916800.0;
  s = r2 * s + 1.0 / 362880.0;
  s = r2 * s - 1.0 / 5040.0;
  s = r2 * s + 1.0 / 120.0;
  s = r2 * s - 1.0 / 6.0;
  s = r + r * r2 * s;
  Lanes c = r2 * (1.0 / 20922789888000.0) - 1.0 / 87178291200.0;
  c = r2 * c + 1.0 / 479001600.0;
  c = r2 * c - 1.0 / 3628800.0;
  c = r2 * c + 1.0 / 40320.0;
  c = r2 * c - 1.0 / 720.0;
  c = r2 * c + 1.0 / 24.0;
  c = 1.0 - 0.5 * r2 + r2 * r2 * c;
  sine = select(is_first, s, select(is_last, -s, c));
  cosine = select(is_first, c, select(is_last, -c, -s));
}

ALIDADE_ALWAYS_INLINE bool isAny(const LaneMask& mask) {
  return (mask[0] | mask[1] | mask[2] | mask[3]) != 0;
}

ALIDADE_ALWAYS_INLINE bool isAll(const LaneMask& mask) {
  // In halves, which takes fewer instructions than lane by lane.
  const auto half = __builtin_shufflevector(mask, mask, 0, 1) & __builtin_shufflevector(mask, mask, 2, 3);
  return (half[0] & half[1]) != 0;
}
#endif

ALIDADE_ALWAYS_INLINE Lanes load(const double* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

ALIDADE_ALWAYS_INLINE void store(const Lanes& lanes, double* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

#if defined(ALIDADE_HAS_VECTORS)
#pragma GCC diagnostic pop
#endif

}  // namespace lane
}  // namespace alidade
