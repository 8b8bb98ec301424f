// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <optional>

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
struct TextbookLens<KannalaBrandt> {
  static std::optional<RealVector2> project(const double* k, const RealVector3& ray) {
    const Real theta = std::atan2(std::hypot(ray.x(), ray.y()), ray.z());
    const Real t2 = theta * theta;
    return textbook::atRadius(ray, theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))));
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
