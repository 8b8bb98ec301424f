// SPDX-License-Identifier: MIT
#include "alidade/camera/domain.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace alidade {
namespace {

constexpr int kNumAngles = 512;            // steps from the axis to the limit
constexpr int kNumAnglesSymmetric = 4096;  // the same if one azimuth represents all
constexpr int kNumAzimuths = 64;           // around the axis, for lenses that are not symmetric
constexpr int kNumRimPoints = 256;
constexpr double kShareOfRest = 0.1;  // largest step, as a share of the remaining way to the limit
constexpr double kLastStep = 1e-6;    // rad; a shorter remaining way is one step
constexpr double kSameAngle = 1e-9;
constexpr double kShareOfWay = 0.8;  // of the way to a neighbouring fold; refined searches begin there
// Below this firmness, a pixel's own rounding moves its ray by more than 1e-9 rad.
constexpr double kMinFirmness = 2.2e-7;

// Sampled field angles from the axis to the limit, the same at all azimuths.
struct Angles {
  std::vector<double> angle, sine, cosine;

  Angles(double limit, int num_angles) {
    const double step = limit / num_angles;
    add(0.0);
    for (int i = 1; angle.back() < limit * (1 - 2e-12); ++i) {
      // Near a pole, at or just beyond the limit, a lens bends within ever smaller angles.
      const double rest = limit - angle.back();
      const double short_step = kShareOfRest * rest;
      const double longest = short_step < step ? angle.back() + short_step : i * step;
      add(rest <= kLastStep ? limit * (1 - 1e-12) : longest);
    }
  }

 private:
  void add(double next) {
    angle.push_back(next);
    sine.push_back(std::sin(next));
    cosine.push_back(std::cos(next));
  }
};

// Firmness with which a pixel determines its ray: the smaller singular value of the Jacobian on the sphere,
// with the sign of the determinant, divided by the magnitude of the coordinates in the plane, which
// determines rounding. 1/sqrt(2) on the axis and about that along all of a perspective plane; -1 if the lens
// has no value.
class Firmness {
 public:
  explicit Firmness(const LensFunction& lens) : lens_(lens) {
    LensBlock block{};
    block.ray[2][0] = 1.0;
    lens_(block, 1);
    if (std::isnan(block.m[0][0])) return;
    const auto& J = block.J_m_ray;
    axis_scale_ = std::sqrt(std::abs(J[0][0] * J[4][0] - J[1][0] * J[3][0]));
  }

  // `azimuth` is a unit vector.
  double operator()(double angle, const Eigen::Vector2d& azimuth) const {
    const double sine = std::sin(angle);
    const double cosine = std::cos(angle);
    double value = 0;
    look(azimuth, &sine, &cosine, 1, &value);
    return value;
  }

  // The same for angles from the i-th on, at most one block of them.
  void operator()(const Angles& angles, std::size_t i, const Eigen::Vector2d& azimuth,
                  LensBlock::Column& values) const {
    const std::size_t count = std::min(LensBlock::kMaxRays, angles.angle.size() - i);
    look(azimuth, angles.sine.data() + i, angles.cosine.data() + i, count, values.data());
  }

 private:
  void look(const Eigen::Vector2d& azimuth, const double* sine, const double* cosine, std::size_t count,
            double* values) const {
    const double ca = azimuth.x();
    const double sa = azimuth.y();
    LensBlock block;
    for (std::size_t i = 0; i < count; ++i) {
      block.ray[0][i] = sine[i] * ca;
      block.ray[1][i] = sine[i] * sa;
      block.ray[2][i] = cosine[i];
    }
    lens_(block, count);
    const auto& J = block.J_m_ray;
    for (std::size_t i = 0; i < count; ++i) {
      const double s = sine[i];
      const double c = cosine[i];
      const double along_x = J[0][i] * (c * ca) + J[1][i] * (c * sa) - J[2][i] * s;
      const double along_y = J[3][i] * (c * ca) + J[4][i] * (c * sa) - J[5][i] * s;
      const double across_x = J[1][i] * ca - J[0][i] * sa;
      const double across_y = J[4][i] * ca - J[3][i] * sa;
      const double det = along_x * across_y - along_y * across_x;
      const double size =
          std::sqrt((along_x * along_x + along_y * along_y) + (across_x * across_x + across_y * across_y));
      const double radius = std::sqrt(block.m[0][i] * block.m[0][i] + block.m[1][i] * block.m[1][i]);
      const double value = det / (size * (axis_scale_ + radius));
      values[i] = std::isfinite(value) ? value : -1.0;
    }
  }

  const LensFunction& lens_;
  double axis_scale_ = 0;
};

// Minimum of f on [a, b] by golden section; f must be unimodal there.
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

// The last place, to 1e-14, before f falls from above zero at `good` to zero or less at `bad`; f may jump.
// Steps of the secant that are pulled to the middle, where needed, so that they are at most two more than a
// bisection's: the ITP method of Oliveira and Takahashi (ACM Transactions on Mathematical Software 47, 2020).
template <class F>
double lastGood(const F& f, double good, double bad) {
  constexpr double kTolerance = 0.5e-14;
  double f_good = f(good);
  double f_bad = f(bad);
  const double pull = 0.2 / (bad - good);
  // Half of the widest bracket from which bisection still ends at most one step late.
  double allowed = bad - good;
  while (bad - good > 2 * kTolerance) {
    const double half = 0.5 * (bad - good);
    const double middle = good + half;
    const double secant = (f_good * bad - f_bad * good) / (f_good - f_bad);
    const double way = middle - secant;
    const double step = std::min(pull * 4 * half * half, std::abs(way));
    const double pulled = secant + std::copysign(step, way);
    const double reach = std::max(0.0, allowed - half);
    double next = std::abs(pulled - middle) <= reach ? pulled : middle - std::copysign(reach, way);
    if (!(next > good && next < bad)) next = middle;
    if (!(next > good && next < bad)) break;  // neighbouring numbers
    const double value = f(next);
    if (value > 0) {
      good = next;
      f_good = value;
    } else {
      bad = next;
      f_bad = value;
    }
    allowed *= 0.5;
  }
  return good;
}

// First of the angles at which the lens folds along one azimuth, or a value above all angles. A near fold
// counts as kFoldMargin farther out, so that the certified cone ends at the near fold itself. The search
// begins at `start`, or at the axis if the lens has folded at `start` already.
double firstFold(const Firmness& firmness, const Angles& angles, double limit, double azimuth,
                 double start = 0) {
  const Eigen::Vector2d direction(std::cos(azimuth), std::sin(azimuth));
  const auto f = [&](double angle) { return firmness(angle, direction); };
  const auto lastAbove = [&](double level, double good, double bad) {
    return lastGood([&](double angle) { return f(angle) - level; }, good, bad);
  };
  const auto foldIn = [&](double good, double bad) {
    const double weak = lastAbove(kMinFirmness, good, bad);
    const double beyond = std::min(weak + kFoldMargin, limit);
    return f(beyond) > 0 ? beyond : lastAbove(0.0, weak, beyond);
  };
  LensBlock::Column values{};
  double before = 0;
  double here = 0;
  const auto first =
      static_cast<std::size_t>(std::ranges::lower_bound(angles.angle, start) - angles.angle.begin());
  for (std::size_t i = first; i < angles.angle.size(); ++i) {
    const std::size_t in_block = (i - first) % LensBlock::kMaxRays;
    if (in_block == 0) firmness(angles, i, direction, values);
    const double next = values[in_block];
    if (!(next > kMinFirmness)) {
      if (i == first) return i == 0 ? 0.0 : firstFold(firmness, angles, limit, azimuth);
      return foldIn(angles.angle[i - 1], angles.angle[i]);
    }
    // A minimum that touches zero between two samples.
    if (i >= first + 2 && here <= before && here <= next && here < 0.5) {
      const double earlier = angles.angle[i - 2];
      const double bottom = goldenMinimum(f, earlier, angles.angle[i], 40);
      if (!(f(bottom) > kMinFirmness)) return foldIn(earlier, bottom);
    }
    before = here;
    here = next;
  }
  return 2 * std::numbers::pi;
}

// Smallest of the first folds over all azimuths.
double firstFoldAround(const Firmness& firmness, double limit) {
  const Angles angles(limit, kNumAngles);
  const auto fold = [&](double azimuth, double start = 0) {
    return firstFold(firmness, angles, limit, azimuth, start);
  };
  const double step = 2 * std::numbers::pi / kNumAzimuths;
  std::vector<double> folds(kNumAzimuths);
  for (int i = 0; i < kNumAzimuths; ++i) folds[static_cast<std::size_t>(i)] = fold(i * step);
  double first = *std::min_element(folds.begin(), folds.end());
  if (first > limit) return first;
  // Refines every minimum whose sample is within one step's change of the lowest sample.
  for (int i = 0; i < kNumAzimuths; ++i) {
    const double left = folds[static_cast<std::size_t>((i + kNumAzimuths - 1) % kNumAzimuths)];
    const double right = folds[static_cast<std::size_t>((i + 1) % kNumAzimuths)];
    const double here = folds[static_cast<std::size_t>(i)];
    if (here > left || here > right || here > limit) continue;
    // If all azimuths end alike, at the limit of the sphere, there is no minimum to refine.
    if (std::max(left, right) - here < kSameAngle) continue;
    // The refined searches skip most of the way, which is free at the sampled azimuths; the azimuth that they
    // find is searched from the axis.
    const auto near = [&](double azimuth) { return fold(azimuth, kShareOfWay * here); };
    first = std::min(first, fold(goldenMinimum(near, (i - 1) * step, (i + 1) * step, 30)));
  }
  return first;
}

// True if the cone's rim has an image that does not cross itself.
bool hasSimpleRim(const LensFunction& lens, double angle) {
  std::vector<Eigen::Vector2d> rim(kNumRimPoints);
  for (int i = 0; i < kNumRimPoints; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / kNumRimPoints;
    const Eigen::Vector3d ray(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                              std::cos(angle));
    LensBlock block{};
    for (std::size_t c = 0; c < 3; ++c) block.ray[c][0] = ray[static_cast<Eigen::Index>(c)];
    lens(block, 1);
    if (std::isnan(block.m[0][0])) return false;
    rim[static_cast<std::size_t>(i)] = {block.m[0][0], block.m[1][0]};
  }
  const auto side = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()) > 0;
  };
  const auto point = [&](int i) { return rim[static_cast<std::size_t>(i % kNumRimPoints)]; };
  for (int i = 0; i < kNumRimPoints; ++i) {
    for (int j = i + 2; j < kNumRimPoints; ++j) {
      if (i == 0 && j == kNumRimPoints - 1) continue;  // adjacent edges
      const Eigen::Vector2d a = point(i), b = point(i + 1), c = point(j), d = point(j + 1);
      if (side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)) return false;
    }
  }
  return true;
}

// Largest angle up to max_angle with a simple rim; a sufficiently small rim is always simple.
double largestSimpleRim(const LensFunction& lens, double max_angle) {
  double good = 0;
  double bad = max_angle;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (good + bad);
    (hasSimpleRim(lens, middle) ? good : bad) = middle;
  }
  return good;
}

}  // namespace

CertifiedCone certifyCone(const LensFunction& lens, const ConeLimits& limits) {
  const double limit = std::min(limits.model_rad, limits.closed_form_rad);
  const Firmness firmness(lens);
  double first = limits.is_axially_symmetric
                     ? firstFold(firmness, Angles(limit, kNumAnglesSymmetric), limit, 0.0)
                     : firstFoldAround(firmness, limit);
  if (limits.closed_form_rad < limits.model_rad) first = std::min(first, limits.closed_form_rad);
  CertifiedCone cone;
  cone.is_limited_by_fold = first <= limits.model_rad;
  cone.max_angle_rad = cone.is_limited_by_fold ? std::max(0.0, first - limits.margin_rad) : limits.model_rad;
  if (!limits.is_one_to_one_without_fold && !limits.is_axially_symmetric &&
      !hasSimpleRim(lens, cone.max_angle_rad)) {
    cone.max_angle_rad = largestSimpleRim(lens, cone.max_angle_rad);
    cone.is_limited_by_fold = true;
  }
  return cone;
}

}  // namespace alidade
