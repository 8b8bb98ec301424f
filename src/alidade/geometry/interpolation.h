// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/geometry/se3.h"
#include "alidade/geometry/so3.h"

namespace alidade {

/// The rotation a fraction `t` of the way from `a` to `b` along the shortest arc, at constant angular
/// velocity: a exp(t log(a^-1 b)), which is the spherical interpolation of Shoemake 1985. t = 0 gives a, t =
/// 1 gives b, and outside [0, 1] the motion goes on at the same rate. Half a turn apart there are two
/// shortest arcs; the sign rule of BasicSO3::log() takes one, and then interpolate(a, b, t) and
/// interpolate(b, a, 1 - t) may be on different arcs.
template <class T>
[[nodiscard]] BasicSO3<T> interpolate(const BasicSO3<T>& a, const BasicSO3<T>& b,
                                      const typename BasicSO3<T>::Scalar& t) {
  return a * BasicSO3<T>::exp(t * (a.inverse() * b).log());
}

/// The rigid motion a fraction `t` of the way from `a` to `b` at a constant twist, a exp(t log(a^-1 b)): a
/// screw motion about a fixed axis. It does not depend on the choice of either frame's origin, and in return
/// the translation follows a helix, not the straight line between the two translations. `t` and half a turn
/// as above.
template <class T>
[[nodiscard]] BasicSE3<T> interpolate(const BasicSE3<T>& a, const BasicSE3<T>& b,
                                      const typename BasicSE3<T>::Scalar& t) {
  return a * BasicSE3<T>::exp(t * (a.inverse() * b).log());
}

}  // namespace alidade
