// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/inverse_start.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Models that start from x = X/Z, y = Y/Z stop here: at 89.94 degrees, a ray meets the plane 1000 focal
/// lengths from the axis, where the powers in the distortion polynomials still keep their digits.
inline constexpr double kPerspectiveMaxAngle = std::numbers::pi / 2 - 1e-3;

namespace detail {

/// A point of the normalised plane, its image under a distortion, and the 2x2 Jacobian between them.
template <class T>
struct WarpSample {
  T mx, my;
  T dmx_dx, dmx_dy, dmy_dx, dmy_dy;

  [[nodiscard]] ALIDADE_ALWAYS_INLINE T det() const { return dmx_dx * dmy_dy - dmx_dy * dmy_dx; }
};

/// Brown's distortion of the plane, radial and tangential.
template <class K, class T>
ALIDADE_ALWAYS_INLINE WarpSample<T> radialTangentialWarp(const T& x, const T& y,
                                                         const RadialFactor<T>& radial, const K& p1,
                                                         const K& p2) {
  const T a = radial.a;
  const T da = radial.da;
  const T r2 = x * x + y * y;
  const T xy2 = 2.0 * x * y;
  WarpSample<T> s;
  s.mx = x * a + p1 * xy2 + p2 * (r2 + 2.0 * x * x);
  s.my = y * a + p1 * (r2 + 2.0 * y * y) + p2 * xy2;
  s.dmx_dx = a + 2.0 * x * x * da + 2.0 * p1 * y + 6.0 * p2 * x;
  s.dmx_dy = xy2 * da + 2.0 * p1 * x + 2.0 * p2 * y;
  s.dmy_dx = s.dmx_dy;
  s.dmy_dy = a + 2.0 * y * y * da + 6.0 * p1 * y + 2.0 * p2 * x;
  return s;
}

/// Adds the terms of a thin prism, with its four parameters, to a distortion of the plane.
template <class K, class T>
ALIDADE_ALWAYS_INLINE void addPrism(const K* k, const T& x, const T& y, WarpSample<T>& s) {
  const T r2 = x * x + y * y;
  const T slope_x = 2.0 * (k[0] + 2.0 * r2 * k[1]);
  const T slope_y = 2.0 * (k[2] + 2.0 * r2 * k[3]);
  s.mx = s.mx + r2 * (k[0] + r2 * k[1]);
  s.my = s.my + r2 * (k[2] + r2 * k[3]);
  s.dmx_dx = s.dmx_dx + slope_x * x;
  s.dmx_dy = s.dmx_dy + slope_x * y;
  s.dmy_dx = s.dmy_dx + slope_y * x;
  s.dmy_dy = s.dmy_dy + slope_y * y;
}

/// The derivatives of these terms by the four parameters.
template <class T>
ALIDADE_ALWAYS_INLINE void prismDerivatives(const T& x, const T& y, T* dmx, T* dmy) {
  const T r2 = x * x + y * y;
  dmx[0] = dmy[2] = r2;
  dmx[1] = dmy[3] = r2 * r2;
  dmx[2] = dmx[3] = dmy[0] = dmy[1] = 0.0 * r2;
}

/// The derivatives of the tangential terms by p1 and p2.
template <class T>
ALIDADE_ALWAYS_INLINE void tangentialDerivatives(const T& x, const T& y, T* dmx, T* dmy) {
  const T r2 = x * x + y * y;
  dmx[0] = dmy[1] = 2.0 * x * y;
  dmx[1] = r2 + 2.0 * x * x;
  dmy[0] = r2 + 2.0 * y * y;
}

/// Jacobian (row-major 2x3) by the ray of a distortion of the plane x = X/Z, y = Y/Z, with iz = 1/Z.
template <class T>
ALIDADE_ALWAYS_INLINE void warpJacobian(const WarpSample<T>& s, const T& x, const T& y, const T& iz,
                                        T* J_m_ray) {
  J_m_ray[0] = s.dmx_dx * iz;
  J_m_ray[1] = s.dmx_dy * iz;
  J_m_ray[2] = -(s.dmx_dx * x + s.dmx_dy * y) * iz;
  J_m_ray[3] = s.dmy_dx * iz;
  J_m_ray[4] = s.dmy_dy * iz;
  J_m_ray[5] = -(s.dmy_dx * x + s.dmy_dy * y) * iz;
}

/// The same for a distortion of any plane, from the Jacobian of the plane's coordinates by the ray.
template <class T>
ALIDADE_ALWAYS_INLINE void warpJacobian(const WarpSample<T>& s, const T* J_plane_ray, T* J_m_ray) {
  for (int i = 0; i < 3; ++i) {
    J_m_ray[i] = s.dmx_dx * J_plane_ray[i] + s.dmx_dy * J_plane_ray[3 + i];
    J_m_ray[3 + i] = s.dmy_dx * J_plane_ray[i] + s.dmy_dy * J_plane_ray[3 + i];
  }
}

/// Newton's method for warp(x, y) = (mx, my) from the given start, kept inside the disc of radius rho_max and
/// never allowed to increase the residual. Returns true at a root inside the disc.
template <class Warp>
bool newtonInDisc(const Warp& warp, double mx, double my, double rho_max, double& x, double& y) {
  constexpr int kMaxIterations = 60;
  constexpr int kMaxClamped = 8;  // steps in a row that end on the rim: the root lies beyond it
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  constexpr double kSameRoot = 1e-9;
  WarpSample<double> s = warp(x, y);
  double rx = mx - s.mx;
  double ry = my - s.my;
  int num_clamped = 0;
  for (int i = 0; i < kMaxIterations; ++i) {
    const double det = s.det();
    if (!(det > 0.0)) return false;
    const double dx = (s.dmy_dy * rx - s.dmx_dy * ry) / det;
    const double dy = (s.dmx_dx * ry - s.dmy_dx * rx) / det;
    const double step = std::hypot(dx, dy);
    const double scale = 1.0 + std::hypot(x, y);
    if (step <= 2 * kEpsilon * scale) return true;

    const double residual = std::hypot(rx, ry);
    bool moved = false;
    for (double t = 1.0; t > 1e-6; t *= 0.5) {
      double nx = x + t * dx;
      double ny = y + t * dy;
      const double rho = std::hypot(nx, ny);
      const bool is_clamped = rho > rho_max;
      if (is_clamped) {
        nx *= rho_max / rho;
        ny *= rho_max / rho;
      }
      const WarpSample<double> n = warp(nx, ny);
      const double new_rx = mx - n.mx;
      const double new_ry = my - n.my;
      if (!(std::hypot(new_rx, new_ry) < residual)) continue;
      x = nx;
      y = ny;
      s = n;
      rx = new_rx;
      ry = new_ry;
      num_clamped = is_clamped ? num_clamped + 1 : 0;
      moved = true;
      break;
    }
    if (num_clamped > kMaxClamped) return false;
    // Newton's steps descend until rounding stops them: the residual is then of a few bits, or, where terms
    // of the warp nearly cancel, of as many as move the root by nothing. Near a fold, steps stay long even at
    // a root.
    if (!moved) {
      return step <= kSameRoot * scale || residual <= 64 * kEpsilon * (std::hypot(mx, my) + std::hypot(x, y));
    }
  }
  return false;
}

/// Solves warp(x, y) = (mx, my) for the point inside the disc of radius rho_max, on which the warp is
/// one-to-one and fixes the origin. Returns false when there is none.
template <class Warp>
bool invertWarp(const Warp& warp, double mx, double my, double rho_max, double& x, double& y) {
  const double m = std::hypot(mx, my);
  if (!std::isfinite(m)) return false;
  const double shrink = m > rho_max ? rho_max / m : 1.0;
  x = shrink * mx;
  y = shrink * my;
  if (newtonInDisc(warp, mx, my, rho_max, x, y)) return true;

  // The direct start got stuck. Follow the preimage of the segment from the origin to m instead, in steps for
  // which Newton's method converges.
  constexpr double kFirstStep = 1.0 / 16;
  constexpr double kShortestStep = kFirstStep / 256;
  double t = 0.0;
  double step = kFirstStep;
  x = y = 0.0;
  while (t < 1.0) {
    const double next = std::min(1.0, t + step);
    double nx = x;
    double ny = y;
    if (newtonInDisc(warp, next * mx, next * my, rho_max, nx, ny)) {
      t = next;
      x = nx;
      y = ny;
      step *= 2;
    } else {
      step *= 0.25;
      if (step < kShortestStep) return false;
    }
  }
  return true;
}

/// Largest radius in the plane for which inverses are tabulated as starts: 63 degrees.
inline constexpr double kMaxStartRadius = 2.0;

/// A step of Newton's method for warp(x, y) = (mx, my); returns the squared residual before it.
template <class T, class Warp>
ALIDADE_ALWAYS_INLINE T newtonStep(const Warp& warp, const T& mx, const T& my, T& x, T& y) {
  const WarpSample<T> s = warp(x, y);
  const T rx = mx - s.mx;
  const T ry = my - s.my;
  const T inverse_det = 1.0 / s.det();
  x = x + (s.dmy_dy * rx - s.dmx_dy * ry) * inverse_det;
  y = y + (s.dmx_dx * ry - s.dmy_dx * rx) * inverse_det;
  return rx * rx + ry * ry;
}

/// Newton's method without safeguards for warp(x, y) = (mx, my), on lanes: NaN where it does not converge to
/// a root within a few steps. A root inside the disc on which the warp is one-to-one is always the right one;
/// roots outside the disc are invalid.
/// @param start  the inverse of the warp's radial part, an InverseStart or like it
template <class T, class Warp, class Start>
ALIDADE_ALWAYS_INLINE void quickInvertWarp(const Warp& warp, const Start& start, const T& mx, const T& my,
                                           T& x, T& y) {
  constexpr int kMaxSteps = 8;
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
  constexpr double kNear = 1e-7;  // residual whose square is rounding, however the last steps converged
  const T m2 = mx * mx + my * my;
  const T scale = start.scale(m2);
  x = scale * mx;
  y = scale * my;
  // Corrects the rest, mostly the tangential part, as if the warp only scaled.
  const WarpSample<T> at_start = warp(x, y);
  x = x + scale * (mx - at_start.mx);
  y = y + scale * (my - at_start.my);
  T before2 = newtonStep(warp, mx, my, x, y);
  T here2 = newtonStep(warp, mx, my, x, y);
  for (int i = 0;; ++i) {
    // Predicts the next residual from two, here^3 / before^2, so that it need not be computed: most lenses
    // and pixels are done here. All values are squares.
    const T length2 = m2 + x * x + y * y;
    const T predicted2 = here2 * here2 * here2;
    const auto is_root = lane::both(here2 <= kNear * kNear * length2,
                                    predicted2 <= kRounding * kRounding * length2 * (before2 * before2));
    if (lane::isAll(is_root)) return;
    if (i == kMaxSteps) {
      x = lane::select(is_root, x, T(mx * std::numeric_limits<double>::quiet_NaN()));
      return;
    }
    T next_x = x;
    T next_y = y;
    const T next2 = newtonStep(warp, mx, my, next_x, next_y);
    // If rounding stops the descent, the residuals predict nothing, but the point is a root too.
    const auto is_done = lane::both(next2 <= kRounding * kRounding * length2, next2 == next2);
    x = lane::select(is_root, x, next_x);
    y = lane::select(is_root, y, next_y);
    before2 = lane::select(is_root, before2, lane::select(is_done, T(0.0 * next2 + 1.0), here2));
    here2 = lane::select(is_root, here2, lane::select(is_done, T(0.0 * next2), next2));
  }
}

}  // namespace detail

/// Common part of the models that distort the plane x = X/Z, y = Y/Z. M has radial(k, r2), the radial part of
/// its distortion; warp(k, x, y), the whole distortion; and lensDerivatives(k, x, y, dmx, dmy), its
/// derivatives by the parameters.
template <class M, std::size_t kNum>
struct PlaneFormula : LensFormula<M, kNum> {
  static constexpr double kMaxAngle = kPerspectiveMaxAngle;
  static constexpr LensFamily kFamily = LensFamily::kPerspective;

  template <class T>
  static bool hasValue(const T*, const T* ray) {
    return ray[2] > 0.0;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    const T iz = 1.0 / ray[2];
    const T x = ray[0] * iz;
    const T y = ray[1] * iz;
    const detail::WarpSample<T> s = M::warp(k, x, y);
    m[0] = s.mx;
    m[1] = s.my;
    if (J_m_ray != nullptr) detail::warpJacobian(s, x, y, iz, J_m_ray);
    if (J_m_lens != nullptr) M::lensDerivatives(k, x, y, J_m_lens, J_m_lens + M::kNumLensParams);
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    // Adds a nanoradian so that a ray on the rim of the domain survives rounding.
    const double rho_max = std::tan(max_angle + 1e-9);
    const auto warp = [k](double x, double y) { return M::warp(k, x, y); };
    double x = 0;
    double y = 0;
    if (!detail::invertWarp(warp, m[0], m[1], rho_max, x, y)) return false;
    const double norm = std::hypot(x, y, 1.0);
    ray[0] = x / norm;
    ray[1] = y / norm;
    ray[2] = 1.0 / norm;
    return true;
  }

  using Start = detail::InverseStart;
  static Start makeStart(const double* k, double max_angle) {
    return {[k](double r2) { return M::radial(k, r2); },
            std::min(std::tan(max_angle), detail::kMaxStartRadius)};
  }
  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m, double,
                                                T* ray) {
    T x;
    T y;
    detail::quickInvertWarp([k](const T& px, const T& py)
                                ALIDADE_INLINE_LAMBDA { return M::warp(k, px, py); },
                            start, m[0], m[1], x, y);
    const T iz = 1.0 / lane::squareRoot(T(x * x + y * y + 1.0));
    ray[0] = x * iz;
    ray[1] = y * iz;
    ray[2] = iz;
  }
};

}  // namespace alidade
