// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "alidade/core/lanes.h"

namespace alidade::detail {

/// w d + (1 - w) z for d = sqrt(rho2 + z^2). Behind the camera d and z nearly cancel; there the digits are
/// kept by d + z = rho2 / (d - z).
template <class K, class T>
ALIDADE_ALWAYS_INLINE T blend(const K& w, const T& rho2, const T& z, const T& d) {
  const T behind = w * rho2 / (d - z) + (1.0 - 2.0 * w) * z;
  return lane::select(z > 0.0, T(w * d + (1.0 - w) * z), behind);
}

/// d times the derivative of w d + (1 - w) z by z, which is w z + (1 - w) d, in the same way.
template <class K, class T>
ALIDADE_ALWAYS_INLINE T blendSlope(const K& w, const T& rho2, const T& z, const T& d) {
  const T behind = w * rho2 / (d - z) + (1.0 - 2.0 * w) * d;
  return lane::select(z > 0.0, T(w * z + (1.0 - w) * d), behind);
}

/// xi d + z, the depth seen from a point xi behind the sphere's centre, in the same way.
template <class K, class T>
ALIDADE_ALWAYS_INLINE T shiftedDepth(const K& xi, const T& rho2, const T& z, const T& d) {
  const T behind = xi * rho2 / (d - z) + (1.0 - xi) * z;
  return lane::select(z > 0.0, T(xi * d + z), behind);
}

/// w of the condition z > -w d for a one-to-one projection m = rho / (alpha d + (1 - alpha) z) of a sphere or
/// ellipsoid with d = |(rho, z)|, the last step of `ucm`, `eucm` and `double_sphere`. For alpha <= 1/2 it is
/// the pole, where m goes to infinity; above it is the fold, where m is largest (Usenko et al. 2018, section
/// 2.2).
template <class T>
T sphereLimit(const T& alpha) {
  if (alpha > T(0.5)) return (T(1) - alpha) / alpha;
  return alpha / (T(1) - alpha);
}

/// Depth z for which (m, z) points along the ray with the image m, from r2 = m^2: the inverse of that
/// projection (Usenko et al. 2018, section 2.3). NaN beyond the largest m.
template <class T>
ALIDADE_ALWAYS_INLINE T sphereDepth(double alpha, const T& r2) {
  const T root = lane::squareRoot(T(1.0 - (2.0 * alpha - 1.0) * r2));
  return (1.0 - alpha * alpha * r2) / (alpha * root + (1.0 - alpha));
}

}  // namespace alidade::detail
