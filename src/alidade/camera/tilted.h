// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/thin_prism.h"
#include "alidade/core/lanes.h"

namespace alidade {

namespace detail {

/// The map of the normalised plane to a sensor that is turned by the angles tau_x and then tau_y:
///
///   mx = x / (cos(tau_y) w),  my = (y / cos(tau_x) - tan(tau_x) tan(tau_y) x) / w
///   w  = 1 + x tan(tau_y) / cos(tau_x) - y tan(tau_x)
///
/// which is OpenCV's matrix of the tilt multiplied out and divided by cos(tau_x) cos(tau_y).
template <class K>
struct SensorTilt {
  K tan_x, tan_y, inverse_cos_x, inverse_cos_y;

  explicit SensorTilt(const K* tau) {
    using std::cos;
    using std::tan;
    tan_x = tan(tau[0]);
    tan_y = tan(tau[1]);
    inverse_cos_x = 1.0 / cos(tau[0]);
    inverse_cos_y = 1.0 / cos(tau[1]);
  }

  /// True if the sensor lies before the centre of projection at the point (mx, my) of the plane.
  template <class T>
  bool hasValue(const WarpSample<T>& s) const {
    return 1.0 + tan_y * inverse_cos_x * s.mx - tan_x * s.my > 0.0;
  }

  /// Follows a distortion of the plane.
  template <class T>
  ALIDADE_ALWAYS_INLINE WarpSample<T> after(const WarpSample<T>& s) const {
    const K by_x = tan_y * inverse_cos_x;
    const K across = -tan_x * tan_y;
    const T iw = 1.0 / (1.0 + by_x * s.mx - tan_x * s.my);
    WarpSample<T> to;
    to.mx = inverse_cos_y * s.mx * iw;
    to.my = (inverse_cos_x * s.my + across * s.mx) * iw;
    const T xx = (inverse_cos_y - to.mx * by_x) * iw;
    const T xy = to.mx * tan_x * iw;
    const T yx = (across - to.my * by_x) * iw;
    const T yy = (inverse_cos_x + to.my * tan_x) * iw;
    to.dmx_dx = xx * s.dmx_dx + xy * s.dmy_dx;
    to.dmx_dy = xx * s.dmx_dy + xy * s.dmy_dy;
    to.dmy_dx = yx * s.dmx_dx + yy * s.dmy_dx;
    to.dmy_dy = yx * s.dmx_dy + yy * s.dmy_dy;
    return to;
  }

  /// The point before the tilt; NaN where the sensor lies behind the centre of projection.
  template <class T>
  ALIDADE_ALWAYS_INLINE void undo(const T* m, T* plane) const {
    const T x = m[0] / inverse_cos_y;
    const T y = (m[1] + tan_x * tan_y * x) / inverse_cos_x;
    const T iw = 1.0 - tan_y * inverse_cos_x * x + tan_x * y;
    const T w = lane::select(iw > 0.0, T(1.0 / iw), T(0.0 * iw + lane::kNaN));
    plane[0] = x * w;
    plane[1] = y * w;
  }
};

}  // namespace detail

/// `thin_prism` on a sensor that is tilted against the lens. With (x, y) the map of `thin_prism`, R the
/// rotation Ry(tau_y) Rx(tau_x) with Rx = (1 0 0; 0 cos sin; 0 -sin cos) and Ry = (cos 0 -sin; 0 1 0; sin 0
/// cos):
///
///   w (mx, my, 1) = (r22 0 -r02; 0 r22 -r12; 0 0 1) R (x, y, 1)
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), the 12 of `thin_prism`, tau_x, tau_y (radians, less
/// than 90 degrees; this is OpenCV's order). Domain: as `thin_prism`, and w > 0. The map of the sensor is
/// one-to-one there. Inverse: closed form to the plane before the tilt, then as `thin_prism`. Source: the
/// formula is that of OpenCV's CALIB_TILTED_MODEL, after Louhichi et al. 2007, Self-calibration of
/// Scheimpflug cameras: an easy protocol, Measurement Science and Technology 18(8).
struct Tilted : PlaneFormula<Tilted, 14> {
  static constexpr std::string_view kId = "tilted";
  static constexpr std::string_view kAliases = "opencv14";
  static constexpr std::array<std::string_view, 14> kLensParamNames = {
      "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tau_x", "tau_y"};
  static constexpr ParamRange kTilt = {.min = -1.5, .max = 1.5};
  static constexpr std::array<ParamRange, 14> kLensRanges = {ParamRange{}, {}, {}, {}, {}, {},    {},
                                                             {},           {}, {}, {}, {}, kTilt, kTilt};
  static constexpr bool kIsOneToOneWithoutFold = false;

  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = true;  // as `thin_prism`; ordinary tilts are small
  static constexpr std::string_view kFlexibleId = "";
  static constexpr std::array<LensVector, 4> kVectors = {LensVector{3, 2}, LensVector{8, 10},
                                                         LensVector{9, 11}, LensVector{12, 13}};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"thin_prism"}};

  static double maxAngle(const double* k) { return ThinPrism::maxAngle(k); }

  /// A turned tilt about both axes would come in the other order.
  static bool canTurn(const double* k) { return k[12] == 0 || k[13] == 0; }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    if (!ThinPrism::hasValue(k, ray)) return false;
    return detail::SensorTilt<T>(k + 12).hasValue(ThinPrism::warp(k, T(ray[0] / ray[2]), T(ray[1] / ray[2])));
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> warp(const K* k, const T& x, const T& y) {
    return detail::SensorTilt<K>(k + 12).after(ThinPrism::warp(k, x, y));
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void lensDerivatives(const K* k, const T& x, const T& y, T* dmx, T* dmy) {
    const detail::SensorTilt<K> tilt(k + 12);
    detail::WarpSample<T> before = ThinPrism::warp(k, x, y);
    const T px = before.mx;
    const T py = before.my;
    before.dmx_dx = before.dmy_dy = 0.0 * px + 1.0;
    before.dmx_dy = before.dmy_dx = 0.0 * px;
    const detail::WarpSample<T> s = tilt.after(before);
    ThinPrism::lensDerivatives(k, x, y, dmx, dmy);
    for (int i = 0; i < 12; ++i) {
      const T dx = dmx[i];
      dmx[i] = s.dmx_dx * dx + s.dmx_dy * dmy[i];
      dmy[i] = s.dmy_dx * dx + s.dmy_dy * dmy[i];
    }
    const K by_x = tilt.tan_y * tilt.inverse_cos_x;
    const T iw = 1.0 / (1.0 + by_x * px - tilt.tan_x * py);
    const K sec2_x = tilt.inverse_cos_x * tilt.inverse_cos_x;
    const K sec2_y = tilt.inverse_cos_y * tilt.inverse_cos_y;
    const T dw_x = by_x * tilt.tan_x * px - sec2_x * py;
    const T dw_y = sec2_y * tilt.inverse_cos_x * px;
    dmx[12] = -s.mx * dw_x * iw;
    dmx[13] = (tilt.tan_y * tilt.inverse_cos_y * px - s.mx * dw_y) * iw;
    dmy[12] = (tilt.tan_x * tilt.inverse_cos_x * py - tilt.tan_y * sec2_x * px - s.my * dw_x) * iw;
    dmy[13] = (-tilt.tan_x * sec2_y * px - s.my * dw_y) * iw;
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    double plane[2];
    detail::SensorTilt<double>(k + 12).undo(m, plane);
    return ThinPrism::unlens(k, plane, max_angle, ray);
  }

  struct Start {
    detail::InverseStart plane;
    detail::SensorTilt<double> tilt{std::array<double, 2>{}.data()};
  };
  static Start makeStart(const double* k, double max_angle) {
    return {.plane = ThinPrism::makeStart(k, max_angle), .tilt = detail::SensorTilt<double>(k + 12)};
  }
  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m,
                                                double max_angle, T* ray) {
    T plane[2];
    start.tilt.undo(m, plane);
    ThinPrism::quickUnlens(k, start.plane, plane, max_angle, ray);
  }
};

}  // namespace alidade
