// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/model_list.h"

namespace alidade {

/// Numbers with digits to spare for the references that doubles are held against.
using Real = long double;
using RealVector2 = Eigen::Matrix<Real, 2, 1>;
using RealVector3 = Eigen::Matrix<Real, 3, 1>;

/// The formulas of docs/models.md written down again, as plainly as they stand there and without a thought
/// for speed or digits: a second way to a lens' image of a ray. `k` holds the parameters after fx fy cx cy.
/// Nothing where the ray is on or beyond the pole, behind the camera of a perspective model, or farther out
/// than docs/models.md says of `fov` and `omni`. They know nothing of folds.
template <class M>
struct TextbookLens;

namespace textbook {

inline RealVector2 tangential(Real p1, Real p2, Real x, Real y) {
  const Real r2 = x * x + y * y;
  return {2 * p1 * x * y + p2 * (r2 + 2 * x * x), p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

inline std::optional<RealVector2> rational(const RealVector3& ray, const double* k, const double* s) {
  if (!(ray.z() > 0)) return std::nullopt;
  const Real x = ray.x() / ray.z();
  const Real y = ray.y() / ray.z();
  const Real r2 = x * x + y * y;
  const Real r4 = r2 * r2;
  const Real r6 = r4 * r2;
  const Real below = 1 + k[5] * r2 + k[6] * r4 + k[7] * r6;
  if (!(below > 0)) return std::nullopt;
  const Real a = (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / below;
  return RealVector2(x * a + s[0] * r2 + s[1] * r4, y * a + s[2] * r2 + s[3] * r4) +
         tangential(k[2], k[3], x, y);
}

/// True up to 1000 from the axis, where the plane of perspective models ends.
inline bool isOnPerspectivePlane(Real rho, Real depth) {
  return depth > 0 && std::atan2(rho, depth) <= kPerspectiveMaxAngle;
}

inline std::optional<RealVector2> overDepth(const RealVector3& ray, Real depth) {
  if (!(depth > 0)) return std::nullopt;
  return RealVector2(ray.head<2>() / depth);
}

inline std::optional<RealVector2> atRadius(const RealVector3& ray, Real r) {
  const Real rho = std::hypot(ray.x(), ray.y());
  if (rho == 0) return ray.z() > 0 ? std::optional(RealVector2(0, 0)) : std::nullopt;
  return RealVector2(ray.head<2>() * (r / rho));
}

/// c0 + c1 x + c2 x^2 + ...
inline Real polynomial(std::initializer_list<double> c, Real x) {
  Real sum = 0;
  for (auto i = std::rbegin(c); i != std::rend(c); ++i) sum = sum * x + *i;
  return sum;
}

/// The first radius with a field angle, in lenses that state the angle of a radius: by halving between steps
/// of a table, which ends where the angle turns back or at a radius of 1000. It is kept for the next ray.
template <class Angle>
std::optional<Real> firstRadius(const Angle& angle, std::span<const double> k, Real theta) {
  static thread_local std::vector<double> known;
  static thread_local std::vector<Real> radii;
  static thread_local std::vector<Real> angles;
  if (!std::equal(known.begin(), known.end(), k.begin(), k.end()) || radii.empty()) {
    known.assign(k.begin(), k.end());
    radii = {0};
    angles = {0};
    const auto add = [&](Real r) {
      radii.push_back(r);
      angles.push_back(angle(r));
    };
    for (Real step = 1e-4L; radii.back() < 1000; step *= 1.0005L) {
      const Real next = std::min<Real>(radii.back() + step, 1000);
      const Real middle = radii.back() + (next - radii.back()) / 2;
      if (angle(next) > angle(middle) && angle(middle) > angles.back()) {
        add(next);
        continue;
      }
      Real low = radii.back();
      Real high = next;
      for (int i = 0; i < 120; ++i) {
        const Real third = (high - low) / 3;
        if (angle(low + third) < angle(high - third)) {
          low += third;
        } else {
          high -= third;
        }
      }
      add(low);
      break;
    }
  }
  if (!(theta <= angles.back())) return std::nullopt;
  const auto after = std::max<std::ptrdiff_t>(1, std::ranges::lower_bound(angles, theta) - angles.begin());
  Real low = radii[static_cast<std::size_t>(after - 1)];
  Real high = radii[static_cast<std::size_t>(after)];
  for (int i = 0; i < 70; ++i) {
    const Real middle = (low + high) / 2;
    (angle(middle) < theta ? low : high) = middle;
  }
  return low;
}

/// The point of the plane with the ray (X, Y, h(R)).
template <class Depth>
std::optional<RealVector2> withRay(const Depth& h, std::span<const double> k, const RealVector3& ray) {
  const Real theta = std::atan2(std::hypot(ray.x(), ray.y()), ray.z());
  const auto r = firstRadius([&h](Real x) { return std::atan2(x, h(x)); }, k, theta);
  return r ? atRadius(ray, *r) : std::nullopt;
}

}  // namespace textbook

template <>
struct TextbookLens<Pinhole> {
  static std::optional<RealVector2> project(const double*, const RealVector3& ray) {
    return textbook::overDepth(ray, ray.z());
  }
};

template <>
struct TextbookLens<Radtan> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const double all[8] = {k[0], k[1], k[2], k[3], k[4], 0, 0, 0};
    const double none[4] = {};
    return textbook::rational(ray, all, none);
  }
};

template <>
struct TextbookLens<Rational> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const double none[4] = {};
    return textbook::rational(ray, k, none);
  }
};

template <>
struct TextbookLens<ThinPrism> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    return textbook::rational(ray, k, k + 8);
  }
};

template <>
struct TextbookLens<Brown> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    if (!(ray.z() > 0)) return std::nullopt;
    const Real x = ray.x() / ray.z();
    const Real y = ray.y() / ray.z();
    const Real s = x * x + y * y;
    const Real a = 1 + k[0] * s + k[1] * s * s + k[4] * s * s * s + k[5] * s * s * s * s;
    const RealVector2 d = RealVector2(x * a, y * a) + textbook::tangential(k[2], k[3], x, y);
    return RealVector2(d.x() + k[6] * d.y(), d.y());
  }
};

/// Two rotations and a projection, by matrices.
template <>
struct TextbookLens<Tilted> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const auto flat = textbook::rational(ray, k, k + 8);
    if (!flat) return std::nullopt;
    using Matrix = Eigen::Matrix<Real, 3, 3>;
    const Real cx = std::cos(Real(k[12])), sx = std::sin(Real(k[12]));
    const Real cy = std::cos(Real(k[13])), sy = std::sin(Real(k[13]));
    Matrix about_x, about_y, project_z;
    about_x << 1, 0, 0, 0, cx, sx, 0, -sx, cx;
    about_y << cy, 0, -sy, 0, 1, 0, sy, 0, cy;
    const Matrix R = about_y * about_x;
    project_z << R(2, 2), 0, -R(0, 2), 0, R(2, 2), -R(1, 2), 0, 0, 1;
    const RealVector3 p = project_z * R * RealVector3(flat->x(), flat->y(), 1);
    return textbook::overDepth(p, p.z());
  }
};

template <>
struct TextbookLens<KannalaBrandt> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real theta = std::atan2(std::hypot(ray.x(), ray.y()), ray.z());
    const Real t2 = theta * theta;
    return textbook::atRadius(ray, theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))));
  }
};

template <>
struct TextbookLens<KannalaBrandtSkew> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const auto plain = TextbookLens<KannalaBrandt>::project(k, ray);
    if (!plain) return std::nullopt;
    return RealVector2(plain->x() + k[4] * plain->y(), plain->y());
  }
};

template <>
struct TextbookLens<ThinPrismFisheye> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real theta = std::atan2(std::hypot(ray.x(), ray.y()), ray.z());
    const auto u = textbook::atRadius(ray, theta);
    if (!u) return std::nullopt;
    const Real r2 = u->squaredNorm();
    const Real radial = k[0] * r2 + k[1] * r2 * r2 + k[2] * r2 * r2 * r2 + k[3] * r2 * r2 * r2 * r2;
    return RealVector2(*u * (1 + radial) + textbook::tangential(k[4], k[5], u->x(), u->y()) +
                       r2 * RealVector2(k[6], k[7]));
  }
};

template <>
struct TextbookLens<Fisheye624> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real theta = std::atan2(std::hypot(ray.x(), ray.y()), ray.z());
    Real radius = theta;
    for (int i = 0; i < 6; ++i) radius += k[i] * std::pow(theta, Real(2 * i + 3));
    const auto u = textbook::atRadius(ray, radius);
    if (!u) return std::nullopt;
    const Real r2 = u->squaredNorm();
    const Real dot = 2 * (k[6] * u->x() + k[7] * u->y());
    return RealVector2(u->x() + dot * u->x() + r2 * k[6] + k[8] * r2 + k[9] * r2 * r2,
                       u->y() + dot * u->y() + r2 * k[7] + k[10] * r2 + k[11] * r2 * r2);
  }
};

/// The point of the disc with the ray's point of the plane as its image under `radtan`, by steps from the
/// middle outwards along the preimage of a straight line.
template <>
struct TextbookLens<InverseBrown> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    if (!(ray.z() > 0)) return std::nullopt;
    const RealVector2 to = ray.head<2>() / ray.z();
    // The domain is stated as the cone whose image the largest disc without a fold holds.
    static thread_local std::array<double, 5> known{};
    static thread_local Real reach = -1;
    if (reach < 0 || !std::equal(known.begin(), known.end(), k)) {
      std::copy_n(k, 5, known.begin());
      reach = reachOf(k);
    }
    if (to.norm() > reach) return std::nullopt;
    RealVector2 m(0, 0);
    constexpr int kNumParts = 12;
    for (int i = 1; i <= kNumParts; ++i) {
      for (int step = 0; step < 60; ++step) {
        const RealVector2 change = jacobian(k, m).inverse() * (to * i / kNumParts - plane(k, m));
        m += change;
        if (change.norm() < 1e-17L * (1 + m.norm())) break;
      }
    }
    return m;
  }

 private:
  static RealVector2 plane(const double* k, const RealVector2& m) {
    const Real s = m.squaredNorm();
    return m * (1 + k[0] * s + k[1] * s * s + k[4] * s * s * s) +
           textbook::tangential(k[2], k[3], m.x(), m.y());
  }
  static Eigen::Matrix<Real, 2, 2> jacobian(const double* k, const RealVector2& m) {
    const Real h = 1e-6L * (1 + m.norm());
    Eigen::Matrix<Real, 2, 2> J;
    J << (plane(k, m + RealVector2(h, 0)) - plane(k, m - RealVector2(h, 0))) / (2 * h),
        (plane(k, m + RealVector2(0, h)) - plane(k, m - RealVector2(0, h))) / (2 * h);
    return J;
  }
  static RealVector2 at(Real radius, int i) {
    const Real azimuth = 2 * std::numbers::pi_v<Real> * i / 1000;
    return radius * RealVector2(std::cos(azimuth), std::sin(azimuth));
  }
  static Real reachOf(const double* k) {
    const auto folds = [k](Real radius) {
      for (int i = 0; i < 1000; ++i)
        if (!(jacobian(k, at(radius, i)).determinant() > 0)) return true;
      return false;
    };
    Real good = 0;
    Real bad = 1e-3L;
    while (bad < 1000 && !folds(bad)) good = bad, bad *= 1.005L;
    bad = std::min<Real>(bad, 1000);
    for (int i = 0; i < 50; ++i) (folds((good + bad) / 2) ? bad : good) = (good + bad) / 2;
    Real reach = plane(k, at(good, 0)).norm();
    for (int i = 1; i < 1000; ++i) reach = std::min(reach, plane(k, at(good, i)).norm());
    return reach;
  }
};

template <>
struct TextbookLens<Division> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const auto h = [k](Real r) { return textbook::polynomial({1, 0, k[0], 0, k[1]}, r); };
    return textbook::withRay(h, {k, 2}, ray);
  }
};

template <>
struct TextbookLens<Ocam> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const auto h = [k](Real r) { return textbook::polynomial({1, 0, k[0], k[1], k[2], k[3], k[4]}, r); };
    const auto p = textbook::withRay(h, {k, 7}, ray);
    if (!p) return std::nullopt;
    return RealVector2(p->x() + k[5] * p->y(), p->y() + k[6] * p->x());
  }
};

template <>
struct TextbookLens<FTheta> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real theta = std::atan2(std::hypot(ray.x(), ray.y()), ray.z());
    Real r = theta;
    for (int i = 0; i < 5; ++i) r += k[i] * std::pow(theta, Real(i + 2));
    return textbook::atRadius(ray, r);
  }
};

template <>
struct TextbookLens<FThetaInverse> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const auto angle = [k](Real r) { return textbook::polynomial({0, 1, k[0], k[1], k[2], k[3], k[4]}, r); };
    const Real theta = std::atan2(std::hypot(ray.x(), ray.y()), ray.z());
    const auto r = textbook::firstRadius(angle, {k, 5}, theta);
    return r ? textbook::atRadius(ray, *r) : std::nullopt;
  }
};

template <>
struct TextbookLens<Fov> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real w = k[0];
    const Real rho = std::hypot(ray.x(), ray.y());
    // Below a width of 0.001 the domain is that of a perspective.
    if (w < 1e-3 && !textbook::isOnPerspectivePlane(rho, ray.z())) return std::nullopt;
    if (w == 0) return textbook::overDepth(ray, ray.z());
    return textbook::atRadius(ray, std::atan2(2 * rho * std::tan(w / 2), ray.z()) / w);
  }
};

template <>
struct TextbookLens<Ucm> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real alpha = k[0];
    return textbook::overDepth(ray, alpha * ray.norm() + (1 - alpha) * ray.z());
  }
};

template <>
struct TextbookLens<Omni> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real depth = ray.z() + k[0] * ray.norm();
    if (!textbook::isOnPerspectivePlane(std::hypot(ray.x(), ray.y()), depth)) return std::nullopt;
    const auto m = textbook::overDepth(ray, depth);
    if (!m) return std::nullopt;
    const Real r2 = m->squaredNorm();
    return RealVector2(*m * (1 + k[1] * r2 + k[2] * r2 * r2) +
                       textbook::tangential(k[3], k[4], m->x(), m->y()));
  }
};

template <>
struct TextbookLens<Eucm> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real alpha = k[0];
    const Real rho2 = ray.head<2>().squaredNorm();
    return textbook::overDepth(ray,
                               alpha * std::sqrt(k[1] * rho2 + ray.z() * ray.z()) + (1 - alpha) * ray.z());
  }
};

template <>
struct TextbookLens<DoubleSphere> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real alpha = k[1];
    const Real h = k[0] * ray.norm() + ray.z();
    return textbook::overDepth(ray, alpha * std::sqrt(ray.head<2>().squaredNorm() + h * h) + (1 - alpha) * h);
  }
};

}  // namespace alidade
