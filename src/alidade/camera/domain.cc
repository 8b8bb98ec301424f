// SPDX-License-Identifier: MIT
#include "alidade/camera/domain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace alidade {
namespace {

constexpr int kNumAngles = 512;   // steps from the axis to the limit
constexpr int kNumAzimuths = 64;  // around the axis, for lenses that are not symmetric

// The two singular values' harmonic balance, 2 s1 s2 / (s1^2 + s2^2) with the determinant's sign: in [-1, 1]
// whatever the scale, so that its dips can be compared between the axis and the far field.
double conformality(const LensJacobianFunction& lens, double angle, double azimuth) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double ca = std::cos(azimuth);
  const double sa = std::sin(azimuth);
  std::array<double, 6> J{};
  if (!lens({s * ca, s * sa, c}, J.data())) return -1.0;
  const Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J_m_ray(J.data());
  const Eigen::Vector2d along = J_m_ray * Eigen::Vector3d(c * ca, c * sa, -s);
  const Eigen::Vector2d across = J_m_ray * Eigen::Vector3d(-sa, ca, 0.0);
  const double det = along.x() * across.y() - along.y() * across.x();
  const double size = along.squaredNorm() + across.squaredNorm();
  const double value = 2 * det / size;
  return std::isfinite(value) ? value : -1.0;
}

// Smallest of f on [a, b], by golden section; f has one dip there.
template <class F>
double goldenMinimum(const F& f, double a, double b, int num_iterations) {
  constexpr double kRatio = 0.6180339887498949;
  double x1 = b - kRatio * (b - a);
  double x2 = a + kRatio * (b - a);
  double f1 = f(x1);
  double f2 = f(x2);
  for (int i = 0; i < num_iterations; ++i) {
    if (f1 < f2) {
      b = x2;
      x2 = x1;
      f2 = f1;
      x1 = b - kRatio * (b - a);
      f1 = f(x1);
    } else {
      a = x1;
      x1 = x2;
      f1 = f2;
      x2 = a + kRatio * (b - a);
      f2 = f(x2);
    }
  }
  return 0.5 * (a + b);
}

// First angle in (0, limit) at which the lens folds along one azimuth, or a value above the limit.
double firstFold(const LensJacobianFunction& lens, double limit, double azimuth) {
  const auto f = [&](double angle) { return conformality(lens, angle, azimuth); };
  const auto bisect = [&](double good, double bad) {
    for (int i = 0; i < 60 && bad - good > 1e-14; ++i) {
      const double middle = 0.5 * (good + bad);
      (f(middle) > 0 ? good : bad) = middle;
    }
    return good;
  };
  const double step = limit / kNumAngles;
  double before = f(0.0);
  if (!(before > 0)) return 0.0;
  double here = before;
  for (int i = 1; i <= kNumAngles; ++i) {
    const double angle = i < kNumAngles ? i * step : limit * (1 - 1e-12);
    const double next = f(angle);
    if (!(next > 0)) return bisect(angle - step, angle);
    // A dip that touches zero between two samples: look at its bottom.
    if (i >= 2 && here <= before && here <= next && here < 0.5) {
      const double bottom = goldenMinimum(f, angle - 2 * step, angle, 40);
      if (!(f(bottom) > 0)) return bisect(angle - 2 * step, bottom);
    }
    before = here;
    here = next;
  }
  return 2 * limit;
}

}  // namespace

double sphereDeterminant(const double* J, const Eigen::Vector3d& ray) {
  const Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J_m_ray(J);
  // Rows a, b of the 2x3 matrix, restricted to the plane normal to the ray: det = (a x b) . ray.
  return J_m_ray.row(0).cross(J_m_ray.row(1)).dot(ray);
}

CertifiedCone certifyCone(const LensJacobianFunction& lens, double limit_rad, bool is_axially_symmetric) {
  const auto fold = [&](double azimuth) { return firstFold(lens, limit_rad, azimuth); };
  double first = fold(0.0);
  if (!is_axially_symmetric) {
    const double step = 2 * std::numbers::pi / kNumAzimuths;
    std::vector<double> folds(kNumAzimuths);
    for (int i = 0; i < kNumAzimuths; ++i) folds[static_cast<std::size_t>(i)] = fold(i * step);
    const int best = static_cast<int>(std::min_element(folds.begin(), folds.end()) - folds.begin());
    first = folds[static_cast<std::size_t>(best)];
    if (first <= limit_rad) {
      // All dips that come within a step's reach of the lowest sample are followed to their bottom.
      for (int i = 0; i < kNumAzimuths; ++i) {
        const double left = folds[static_cast<std::size_t>((i + kNumAzimuths - 1) % kNumAzimuths)];
        const double right = folds[static_cast<std::size_t>((i + 1) % kNumAzimuths)];
        const double here = folds[static_cast<std::size_t>(i)];
        if (here > left || here > right || here > limit_rad) continue;
        first = std::min(first, fold(goldenMinimum(fold, (i - 1) * step, (i + 1) * step, 30)));
      }
    }
  }
  CertifiedCone cone;
  cone.is_limited_by_fold = first <= limit_rad;
  cone.max_angle_rad = cone.is_limited_by_fold ? std::max(0.0, first - kFoldMargin) : limit_rad;
  return cone;
}

}  // namespace alidade
