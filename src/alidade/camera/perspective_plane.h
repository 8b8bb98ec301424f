// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace alidade {

/// Models that start from x = X/Z, y = Y/Z stop here: at 89.94 degrees the plane is left at 1000 focal
/// lengths, where the powers in the distortion polynomials still keep their digits.
inline constexpr double kPerspectiveMaxAngle = std::numbers::pi / 2 - 1e-3;

namespace detail {

/// A point of the normalised plane, its image under a distortion, and the 2x2 Jacobian between them.
struct WarpSample {
  double mx = 0, my = 0;
  double dmx_dx = 0, dmx_dy = 0, dmy_dx = 0, dmy_dy = 0;

  [[nodiscard]] double det() const { return dmx_dx * dmy_dy - dmx_dy * dmy_dx; }
};

/// Jacobian (row-major 2x3) by the ray of a distortion of the plane x = X/Z, y = Y/Z, with iz = 1/Z.
inline void warpJacobian(const WarpSample& s, double x, double y, double iz, double* J_m_ray) {
  J_m_ray[0] = s.dmx_dx * iz;
  J_m_ray[1] = s.dmx_dy * iz;
  J_m_ray[2] = -(s.dmx_dx * x + s.dmx_dy * y) * iz;
  J_m_ray[3] = s.dmy_dx * iz;
  J_m_ray[4] = s.dmy_dy * iz;
  J_m_ray[5] = -(s.dmy_dx * x + s.dmy_dy * y) * iz;
}

/// Newton's method for warp(x, y) = (mx, my) from the given start, kept inside the disc of radius rho_max and
/// never allowed to increase the residual. Returns true at a root inside the disc.
template <class Warp>
bool newtonInDisc(const Warp& warp, double mx, double my, double rho_max, double& x, double& y) {
  constexpr int kMaxIterations = 60;
  constexpr int kMaxClamped = 8;  // steps in a row that end on the rim: the root lies beyond it
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  WarpSample s = warp(x, y);
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
      const WarpSample n = warp(nx, ny);
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
    // Rounding stops the descent a few bits above zero residual; anything larger is a wall, not a root. Near
    // a fold the step stays long even there, so the residual decides.
    if (!moved) return residual <= 64 * kEpsilon * (std::hypot(mx, my) + std::hypot(x, y));
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

  // The direct start ran into a wall. Follow the preimage of the segment from the origin to m instead, in
  // steps as long as Newton's method bears.
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

/// The ray whose perspective image the warp takes to m, in the cone of half-angle max_angle.
template <class Warp>
bool unwarpRay(const Warp& warp, const double* m, double max_angle, double* ray) {
  // The last nanoradian lets a ray on the rim of the domain come back despite rounding.
  const double rho_max = std::tan(max_angle + 1e-9);
  double x = 0;
  double y = 0;
  if (!invertWarp(warp, m[0], m[1], rho_max, x, y)) return false;
  const double norm = std::hypot(x, y, 1.0);
  ray[0] = x / norm;
  ray[1] = y / norm;
  ray[2] = 1.0 / norm;
  return true;
}

}  // namespace detail
}  // namespace alidade
