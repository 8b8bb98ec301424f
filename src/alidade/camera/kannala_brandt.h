// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/wide_angle.h"

namespace alidade {

/// Fisheye lenses as an odd polynomial in the field angle. With rho = sqrt(X^2 + Y^2) and
/// theta = atan2(rho, Z):
///
///   r  = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
///   mx = r X / rho,  my = r Y / rho
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, k3, k4 (no unit; OpenCV's fisheye and its
/// order). fx is pixels a radian on the axis. With all k zero the lens is equidistant.
/// Domain: all directions up to the first angle at which r turns back, at most kWideMaxAngle.
/// Inverse: Newton iteration for theta, kept inside a bracket.
/// Source: Kannala and Brandt 2006, A generic camera model and calibration method for conventional,
/// wide-angle, and fish-eye lenses, PAMI 28(8), the radially symmetric model, with the first coefficient
/// taken into fx and fy.
struct KannalaBrandt {
  static constexpr std::string_view kId = "kannala_brandt";
  static constexpr int kNumLensParams = 4;
  static constexpr std::array<std::string_view, 4> kLensParamNames = {"k1", "k2", "k3", "k4"};
  static constexpr std::array<ParamRange, 4> kLensRanges = {};
  static constexpr std::array<double, 4> kStartLens = {0, 0, 0, 0};
  static constexpr double kMaxAngle = kWideMaxAngle;
  static constexpr bool kIsOneToOneWithoutFold = true;

  static double maxAngle(const double*) { return kMaxAngle; }
  static bool isAxiallySymmetric(const double*) { return true; }

  template <class T>
  static bool lens(const T* k, const T* ray, T* m) {
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (!(ray[2] > T(0)) && !(rho2 > T(0))) return false;
    const T q = detail::angleOverRadius(rho2, ray[2]);
    const T t2 = q * q * rho2;
    const T f = q * (T(1) + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
    m[0] = ray[0] * f;
    m[1] = ray[1] * f;
    return true;
  }

  static bool lensJacobian(const double* k, const double* ray, double* m, double* J_m_ray, double* J_m_lens) {
    const double z = ray[2];
    const double rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (!(z > 0.0) && !(rho2 > 0.0)) return false;
    const double q = detail::angleOverRadius(rho2, z);
    const double t2 = q * q * rho2;
    const double b = 1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])));
    m[0] = ray[0] * q * b;
    m[1] = ray[1] * q * b;
    if (J_m_ray != nullptr) {
      const double n2 = rho2 + z * z;
      const double db_dt2 = k[0] + t2 * (2 * k[1] + t2 * (3 * k[2] + t2 * 4 * k[3]));
      const double dq_ds = detail::angleOverRadiusSlope(rho2, z, q);
      const double df_ds = dq_ds * b + q * db_dt2 * q * z / n2;
      const double df_dz = -(b + 2 * t2 * db_dt2) / n2;
      detail::radialJacobian(ray, q * b, df_ds, df_dz, 1.0, J_m_ray);
    }
    if (J_m_lens != nullptr) {
      double power = q;
      for (int i = 0; i < 4; ++i) {
        power *= t2;
        J_m_lens[i] = ray[0] * power;
        J_m_lens[4 + i] = ray[1] * power;
      }
    }
    return true;
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const double r = std::hypot(m[0], m[1]);
    double theta = 0;
    if (!angleOf(k, r, max_angle + 1e-9, theta)) return false;
    // On the axis itself sin(theta) / r is 0 / 0; there m is the ray.
    const double scale = r > 0 ? std::sin(theta) / r : 1.0;
    return detail::makeUnitRay(m[0] * scale, m[1] * scale, std::cos(theta), ray);
  }

 private:
  // Solves r(theta) = r on [0, limit], where r(theta) rises.
  static bool angleOf(const double* k, double r, double limit, double& theta) {
    constexpr int kMaxIterations = 100;
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    const auto radius = [k](double t) {
      const double t2 = t * t;
      return t * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
    };
    if (!(r <= radius(limit))) return false;
    double low = 0;
    double high = limit;
    double last_step = limit;
    theta = std::min(r, limit);
    for (int i = 0; i < kMaxIterations; ++i) {
      const double error = radius(theta) - r;
      if (error == 0.0) return true;
      (error < 0 ? low : high) = theta;
      const double t2 = theta * theta;
      const double slope = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
      double next = theta - error / slope;
      // Where Newton's steps do not at least halve, they may go to and fro for ever.
      const bool is_slow = !(std::abs(next - theta) <= 0.5 * last_step);
      if (is_slow || !(next > low && next < high)) next = 0.5 * (low + high);
      last_step = std::abs(next - theta);
      theta = next;
      if (last_step <= kEpsilon * theta || high - low <= 2 * kEpsilon * high) return true;
    }
    return false;
  }
};

}  // namespace alidade
