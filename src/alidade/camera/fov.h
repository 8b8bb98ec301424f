// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/wide_angle.h"

namespace alidade {

/// Fisheye lenses with one parameter, the field of view w of the ideal fisheye. With rho = sqrt(X^2 + Y^2)
/// and a = 2 tan(w / 2):
///
///   r  = atan2(a rho, Z) / w
///   mx = r X / rho,  my = r Y / rho
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), w (radians, 0 to 3.1; tan(w / 2) has its pole at pi).
/// w = 0 is the perspective projection, which the formula approaches smoothly.
/// Domain: in front of the camera this is the paper's r = atan(2 tan(theta) tan(w / 2)) / w; the arc tangent
/// of two arguments continues it beyond 90 degrees, rising all the way to kWideMaxAngle. For w < 0.001 the
/// lens is a perspective one and all that lies beyond kPerspectiveMaxAngle is left out: its radius, about
/// pi / w, would have lost too many digits.
/// Inverse: closed form.
/// Source: Devernay and Faugeras 2001, Straight lines have to be straight, Machine Vision and Applications
/// 13(1), the FOV model.
struct Fov {
  static constexpr std::string_view kId = "fov";
  static constexpr int kNumLensParams = 1;
  static constexpr std::array<std::string_view, 1> kLensParamNames = {"w"};
  static constexpr std::array<ParamRange, 1> kLensRanges = {ParamRange{.min = 0.0, .max = 3.1}};
  static constexpr std::array<double, 1> kStartLens = {0.9};
  static constexpr double kMaxAngle = kWideMaxAngle;
  static constexpr bool kIsOneToOneWithoutFold = true;

  static double maxAngle(const double* k) { return k[0] < kMinWide ? kPerspectiveMaxAngle : kMaxAngle; }
  static bool isAxiallySymmetric(const double*) { return true; }

  template <class T>
  static bool lens(const T* k, const T* ray, T* m) {
    using std::tan;
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (!hasValue(k[0], rho2, ray[2])) return false;
    const T a = T(2) * tan(T(0.5) * k[0]);
    const T f = axisScale(k[0], a) * detail::angleOverRadius(T(a * a * rho2), ray[2]);
    m[0] = ray[0] * f;
    m[1] = ray[1] * f;
    return true;
  }

  static bool lensJacobian(const double* k, const double* ray, double* m, double* J_m_ray, double* J_m_lens) {
    const double w = k[0];
    const double z = ray[2];
    const double rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (!hasValue(w, rho2, z)) return false;
    const double a = 2 * std::tan(0.5 * w);
    const double scale = axisScale(w, a);
    const double s = a * a * rho2;
    const double q = detail::angleOverRadius(s, z);
    const double dq_ds = detail::angleOverRadiusSlope(s, z, q);
    m[0] = ray[0] * scale * q;
    m[1] = ray[1] * scale * q;
    if (J_m_ray != nullptr) {
      const double df_dz = -scale / (s + z * z);
      detail::radialJacobian(ray, scale * q, scale * dq_ds, df_dz, a * a, J_m_ray);
    }
    if (J_m_lens != nullptr) {
      const double da_dw = 1 + 0.25 * a * a;
      const double df_dw = axisScaleSlope(w, a, da_dw) * q + scale * dq_ds * 2 * a * da_dw * rho2;
      J_m_lens[0] = ray[0] * df_dw;
      J_m_lens[1] = ray[1] * df_dw;
    }
    return true;
  }

  static bool unlens(const double* k, const double* m, double, double* ray) {
    const double w = k[0];
    if (!(w >= 0.0 && w <= kLensRanges[0].max)) return false;
    const double phi = w * std::hypot(m[0], m[1]);  // atan2(a rho, Z)
    if (!(phi < std::numbers::pi)) return false;
    const double sinc = phi < 1e-4 ? 1 - phi * phi / 6 : std::sin(phi) / phi;
    const double scale = sinc / axisScale(w, 2 * std::tan(0.5 * w));
    return detail::makeUnitRay(m[0] * scale, m[1] * scale, std::cos(phi), ray);
  }

 private:
  static constexpr double kMinWide = 1e-3;     // below, nothing is seen behind the camera's plane
  static constexpr double kSmallWidth = 0.03;  // below, a / w is its series

  template <class T>
  static bool hasValue(const T& w, const T& rho2, const T& z) {
    if (!(w >= T(0) && w <= T(kLensRanges[0].max))) return false;
    return z > T(0) || (w >= T(kMinWide) && rho2 > T(0));
  }

  // a / w, the scale on the axis.
  template <class T>
  static T axisScale(const T& w, const T& a) {
    if (w > T(kSmallWidth)) return a / w;
    const T w2 = w * w;
    return T(1) + w2 * (T(1.0 / 12) + w2 * (T(1.0 / 120) + w2 * T(17.0 / 20160)));
  }

  static double axisScaleSlope(double w, double a, double da_dw) {
    if (w > kSmallWidth) return (da_dw - a / w) / w;
    const double w2 = w * w;
    return w * (1.0 / 6 + w2 * (1.0 / 30 + w2 * (17.0 / 3360)));
  }
};

}  // namespace alidade
