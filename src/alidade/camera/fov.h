// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/wide_angle.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Fisheye lenses with one parameter, the field of view w of the ideal fisheye. With rho = sqrt(X^2 + Y^2)
/// and a = 2 tan(w / 2):
///
///   r  = atan2(a rho, Z) / w
///   mx = r X / rho,  my = r Y / rho
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), w (radians, 0 to 3.1; tan(w / 2)
/// has its pole at pi). w = 0 is the perspective projection, which the formula
/// approaches smoothly. Domain: in front of the camera this is the paper's r = atan(2
/// tan(theta) tan(w / 2)) / w; the arc tangent of two arguments continues it beyond 90
/// degrees, rising all the way to kWideMaxAngle. For w < 0.001 the lens is perspective,
/// and the domain ends at kPerspectiveMaxAngle: beyond it, a radius of about pi / w
/// would lose too many digits. Inverse: closed form. Source: Devernay and Faugeras 2001,
/// Straight lines have to be straight, Machine Vision and Applications 13(1), the FOV
/// model.
struct Fov : LensFormula<Fov, 1> {
  static constexpr std::string_view kId = "fov";
  static constexpr std::string_view kAliases = "atan pinhole-fov";
  static constexpr std::array<std::string_view, 1> kLensParamNames = {"w"};
  static constexpr std::array<ParamRange, 1> kLensRanges = {ParamRange{.min = 0.0, .max = 3.1}};
  static constexpr std::array<double, 1> kStartLens = {0.9};
  static constexpr double kMaxAngle = kWideMaxAngle;

  static constexpr LensFamily kFamily = LensFamily::kWide;
  static constexpr bool kIsStiff = true;
  static constexpr bool kIsPolynomial = false;
  static constexpr std::string_view kFlexibleId = "kannala_brandt";
  static constexpr std::array<LensVector, 0> kVectors = {};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"pinhole"}};

  static double maxAngle(const double* k) { return k[0] < kMinWide ? kPerspectiveMaxAngle : kMaxAngle; }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    if (!(k[0] >= 0.0 && k[0] <= kLensRanges[0].max)) return false;
    return ray[2] > 0.0 || (k[0] >= kMinWide && ray[0] * ray[0] + ray[1] * ray[1] > 0.0);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    using std::tan;
    const K w = k[0];
    const K a = 2.0 * tan(0.5 * w);
    const K scale = axisScale(w, a);
    const T z = ray[2];
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const T s = a * a * rho2;
    const T q = detail::angleOverRadius(s, z);
    m[0] = ray[0] * scale * q;
    m[1] = ray[1] * scale * q;
    if (J_m_ray == nullptr && J_m_lens == nullptr) return;
    const T dq_ds = detail::angleOverRadiusSlope(s, z, q);
    if (J_m_ray != nullptr) {
      const T df_dz = -scale / (s + z * z);
      detail::radialJacobian(ray, T(scale * q), T(scale * dq_ds), df_dz, a * a, J_m_ray);
    }
    if (J_m_lens != nullptr) {
      const K da_dw = 1.0 + 0.25 * a * a;
      const T df_dw = axisScaleSlope(w, a, da_dw) * q + scale * dq_ds * 2.0 * a * da_dw * rho2;
      J_m_lens[0] = ray[0] * df_dw;
      J_m_lens[1] = ray[1] * df_dw;
    }
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start&, const T* m, double, T* ray) {
    const double w = k[0];
    T phi = w * lane::squareRoot(T(m[0] * m[0] + m[1] * m[1]));  // atan2(a rho, Z)
    phi = lane::select(phi < std::numbers::pi, phi, T(phi * std::numeric_limits<double>::quiet_NaN()));
    T sine;
    T cosine;
    lane::sineCosine(phi, sine, cosine);
    const T sinc = lane::select(phi < kSmallPhi, T(1.0 - phi * phi / 6.0), T(sine / phi));
    const T scale = sinc / axisScale(w, 2 * std::tan(0.5 * w));
    detail::makeUnitRay(T(m[0] * scale), T(m[1] * scale), cosine, ray);
  }

 private:
  static constexpr double kMinWide = 1e-3;     // below, nothing is seen behind the camera's plane
  static constexpr double kSmallWidth = 0.03;  // below, a / w is its series
  static constexpr double kSmallPhi = 1e-4;    // below, sin(phi) / phi is its series

  // a / w, the scale on the axis.
  template <class T>
  static T axisScale(const T& w, const T& a) {
    if (w > kSmallWidth) return a / w;
    const T w2 = w * w;
    return 1.0 + w2 * (1.0 / 12 + w2 * (1.0 / 120 + w2 * (17.0 / 20160)));
  }

  template <class T>
  static T axisScaleSlope(const T& w, const T& a, const T& da_dw) {
    if (w > kSmallWidth) return (da_dw - a / w) / w;
    const T w2 = w * w;
    return w * (1.0 / 6 + w2 * (1.0 / 30 + w2 * (17.0 / 3360)));
  }
};

}  // namespace alidade
