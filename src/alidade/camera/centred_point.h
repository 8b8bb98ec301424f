// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/wide_angle.h"
#include "alidade/core/lanes.h"

namespace alidade {
namespace detail {

/// A near point moved along the axis so that a lens whose EntrancePupil does not move sees it at the same
/// pixel, with derivatives, for double or Lanes.
template <class T>
struct CentredPoint {
  T z;            ///< of the moved point; x and y stay
  T angle2;       ///< theta^2
  T by_point[3];  ///< how much less z moves than the point's own z, by the point
  T slope;        ///< of the point's z by that of the moved point
  T certainty;    ///< 1 far away; so near that it is below kLeast, the point may have several rays
  static constexpr double kLeast = 0.5;

  /// Turns the row-major derivatives of a pixel by the moved point into those by the point itself.
  ALIDADE_ALWAYS_INLINE void apply(T* J_px_cam) const {
    for (T* J : {J_px_cam, J_px_cam + 3}) {
      const T by_z = J[2];
      for (int i = 0; i < 3; ++i) J[i] -= by_z * by_point[i];
    }
  }
  /// Derivative of z by s1; that by s2 is angle2 times it.
  ALIDADE_ALWAYS_INLINE T byS1() const { return -angle2 / slope; }
};

/// theta solves theta = atan2(rho, z - s(theta)), by Newton's method from the angle of the point.
template <class T>
ALIDADE_ALWAYS_INLINE CentredPoint<T> centredPoint(double s1, double s2, const T* p_cam) {
  constexpr int kSteps = 4;           // each squares the error, which starts at about s / distance
  constexpr double kOffAxis = 1e-30;  // m^2, so that quotients by rho exist on the axis
  const T rho2 = p_cam[0] * p_cam[0] + p_cam[1] * p_cam[1] + kOffAxis;
  const T rho = lane::squareRoot(rho2);
  CentredPoint<T> to;
  to.z = p_cam[2];
  T angle_over_rho = angleOverRadius(rho2, to.z);
  T angle = rho * angle_over_rho;
  T slope_over_rho = {};  // of s by theta, over rho
  T distance2 = {};
  for (int i = 0; i <= kSteps; ++i) {
    to.angle2 = angle * angle;
    slope_over_rho = angle_over_rho * (2.0 * s1 + 4.0 * s2 * to.angle2);
    to.z = p_cam[2] - to.angle2 * (s1 + s2 * to.angle2);
    distance2 = rho2 + to.z * to.z;
    to.slope = 1.0 - slope_over_rho * rho2 / distance2;
    to.certainty = i == 0 ? to.slope : lane::select(to.slope < to.certainty, to.slope, to.certainty);
    if (i == kSteps) break;
    angle = angle + (rho * angleOverRadius(rho2, to.z) - angle) / to.slope;
    angle_over_rho = angle / rho;
  }
  // By implicit differentiation; theta has the gradient (x z / rho, y z / rho, -rho) / distance^2.
  const T share = slope_over_rho / (to.slope * distance2);
  to.by_point[0] = share * p_cam[0] * to.z;
  to.by_point[1] = share * p_cam[1] * to.z;
  to.by_point[2] = -share * rho2;
  return to;
}

}  // namespace detail

}  // namespace alidade
