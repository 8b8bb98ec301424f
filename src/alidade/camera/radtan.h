// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"

namespace alidade {

/// Radial and tangential (Brown-Conrady) distortion of the perspective plane. With x = X/Z, y = Y/Z,
/// r2 = x^2 + y^2 and a = 1 + k1 r2 + k2 r2^2 + k3 r2^3:
///
///   mx = x a + 2 p1 x y + p2 (r2 + 2 x^2)
///   my = y a + p1 (r2 + 2 y^2) + 2 p2 x y
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, p1, p2, k3 (no unit; this is OpenCV's order).
/// Domain: Z > 0 and field angle below the first fold over all azimuths. The map is the gradient of a
/// potential, so its Jacobian is symmetric and a positive determinant on a disc makes it one-to-one there.
/// Inverse: safeguarded Newton iteration inside that disc.
/// Source: Brown 1966, Decentering distortion of lenses, Photogrammetric Engineering 32(3).
struct Radtan {
  static constexpr std::string_view kId = "radtan";
  static constexpr int kNumLensParams = 5;
  static constexpr std::array<std::string_view, 5> kLensParamNames = {"k1", "k2", "p1", "p2", "k3"};
  static constexpr std::array<ParamRange, 5> kLensRanges = {};
  static constexpr std::array<double, 5> kStartLens = {0, 0, 0, 0, 0};
  static constexpr double kMaxAngle = kPerspectiveMaxAngle;
  static constexpr bool kIsOneToOneWithoutFold = true;

  static double maxAngle(const double*) { return kMaxAngle; }
  static bool isAxiallySymmetric(const double* k) { return k[2] == 0.0 && k[3] == 0.0; }

  template <class T>
  static bool lens(const T* k, const T* ray, T* m) {
    if (!(ray[2] > T(0))) return false;
    const T x = ray[0] / ray[2];
    const T y = ray[1] / ray[2];
    const T r2 = x * x + y * y;
    const T a = T(1) + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    const T xy2 = T(2) * x * y;
    m[0] = x * a + k[2] * xy2 + k[3] * (r2 + T(2) * x * x);
    m[1] = y * a + k[2] * (r2 + T(2) * y * y) + k[3] * xy2;
    return true;
  }

  static bool lensJacobian(const double* k, const double* ray, double* m, double* J_m_ray, double* J_m_lens) {
    if (!(ray[2] > 0.0)) return false;
    const double iz = 1.0 / ray[2];
    const double x = ray[0] * iz;
    const double y = ray[1] * iz;
    const detail::WarpSample s = warp(k, x, y);
    m[0] = s.mx;
    m[1] = s.my;
    if (J_m_ray != nullptr) detail::warpJacobian(s, x, y, iz, J_m_ray);
    if (J_m_lens != nullptr) {
      const double r2 = x * x + y * y;
      const double r4 = r2 * r2;
      const double xy2 = 2 * x * y;
      J_m_lens[0] = x * r2;
      J_m_lens[1] = x * r4;
      J_m_lens[2] = xy2;
      J_m_lens[3] = r2 + 2 * x * x;
      J_m_lens[4] = x * r4 * r2;
      J_m_lens[5] = y * r2;
      J_m_lens[6] = y * r4;
      J_m_lens[7] = r2 + 2 * y * y;
      J_m_lens[8] = xy2;
      J_m_lens[9] = y * r4 * r2;
    }
    return true;
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const auto f = [k](double x, double y) { return warp(k, x, y); };
    return detail::unwarpRay(f, m, max_angle, ray);
  }

 private:
  static detail::WarpSample warp(const double* k, double x, double y) {
    const double r2 = x * x + y * y;
    const double a = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    const double da = k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]);  // da / d(r2)
    const double p1 = k[2];
    const double p2 = k[3];
    detail::WarpSample s;
    s.mx = x * a + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
    s.my = y * a + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
    s.dmx_dx = a + 2 * x * x * da + 2 * p1 * y + 6 * p2 * x;
    s.dmx_dy = 2 * x * y * da + 2 * p1 * x + 2 * p2 * y;
    s.dmy_dx = s.dmx_dy;
    s.dmy_dy = a + 2 * y * y * da + 6 * p1 * y + 2 * p2 * x;
    return s;
  }
};

}  // namespace alidade
