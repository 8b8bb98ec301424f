// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

namespace alidade::detail {

/// w d + (1 - w) z for d = sqrt(rho2 + z^2). Behind the camera d and z nearly cancel; there the digits are
/// kept by d + z = rho2 / (d - z).
template <class T>
T blend(const T& w, const T& rho2, const T& z, const T& d) {
  if (z > T(0)) return w * d + (T(1) - w) * z;
  return w * rho2 / (d - z) + (T(1) - T(2) * w) * z;
}

/// d times the derivative of w d + (1 - w) z by z, which is w z + (1 - w) d, in the same way.
inline double blendSlope(double w, double rho2, double z, double d) {
  if (z > 0) return w * z + (1 - w) * d;
  return w * rho2 / (d - z) + (1 - 2 * w) * d;
}

/// xi d + z, the depth seen from a point xi behind the sphere's centre, in the same way.
template <class T>
T shiftedDepth(const T& xi, const T& rho2, const T& z, const T& d) {
  if (z > T(0)) return xi * d + z;
  return xi * rho2 / (d - z) + (T(1) - xi) * z;
}

/// w of the condition z > -w d under which m = rho / (alpha d + (1 - alpha) z), the projection that `ucm`,
/// `eucm` and `double_sphere` end with, is one-to-one on a sphere or ellipsoid of distance d = |(rho, z)|:
/// its pole for alpha <= 1/2, where m goes to infinity, and its fold above, where m is largest (Usenko et al.
/// 2018, section 2.2).
template <class T>
T sphereLimit(const T& alpha) {
  if (alpha > T(0.5)) return (T(1) - alpha) / alpha;
  return alpha / (T(1) - alpha);
}

/// Depth z for which (m, z) points along the ray with the image m, from r2 = m^2: the inverse of that
/// projection (Usenko et al. 2018, section 2.3). False beyond the largest m.
inline bool sphereDepth(double alpha, double r2, double& z) {
  const double root2 = 1 - (2 * alpha - 1) * r2;
  if (!(root2 >= 0.0)) return false;
  z = (1 - alpha * alpha * r2) / (alpha * std::sqrt(root2) + 1 - alpha);
  return std::isfinite(z);
}

}  // namespace alidade::detail
