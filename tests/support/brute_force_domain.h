// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/textbook_lens.h"

namespace alidade {

/// The largest cone about the axis in which a lens neither folds nor has a pole, by dense sampling:
/// differences of the textbook's formula along many azimuths, and around the lowest of them ever closer ones.
/// Shares nothing with the certificate but the question. It is right to 1e-7 rad for whatever is not narrower
/// than its steps.
template <class M>
class BruteForceDomain {
 public:
  /// `lens` holds the parameters after fx fy cx cy.
  explicit BruteForceDomain(const double* lens) : lens_(lens) {
    const int num_azimuths = M::isAxiallySymmetric(lens) ? 1 : kNumAzimuths;
    const double step = 2 * std::numbers::pi / num_azimuths;
    std::vector<double> folds;
    for (int i = 0; i < num_azimuths; ++i) {
      folds.push_back(foldAlong(i * step, 0, max_angle_ + kLookAround));
      max_angle_ = std::min(max_angle_, folds.back());
    }
    if (num_azimuths == 1) return;
    for (int i = 0; i < num_azimuths; ++i) {
      const double here = folds[static_cast<std::size_t>(i)];
      const double left = folds[static_cast<std::size_t>((i + num_azimuths - 1) % num_azimuths)];
      const double right = folds[static_cast<std::size_t>((i + 1) % num_azimuths)];
      const bool is_dip = here <= left && here <= right && std::max(left, right) - here > 10 * kAngleError;
      if (is_dip && here < M::kMaxAngle) followDip(i * step, step, here);
    }
  }

  [[nodiscard]] double maxAngle() const { return max_angle_; }

  /// True if small steps outwards and sideways turn in the image as they do on the sphere.
  [[nodiscard]] bool keepsItsSide(double angle, double azimuth) const {
    const Real h = std::min<Real>(kDifference, Real(0.5) * (Real(M::kMaxAngle) - Real(angle)));
    const RealVector3 side(-std::sin(Real(azimuth)), std::cos(Real(azimuth)), 0);
    const auto out = TextbookLens<M>::project(lens_, direction(angle + h, azimuth));
    const auto in = TextbookLens<M>::project(lens_, direction(angle - h, azimuth));
    const auto left = TextbookLens<M>::project(lens_, direction(angle, azimuth) + h * side);
    const auto right = TextbookLens<M>::project(lens_, direction(angle, azimuth) - h * side);
    if (!out || !in || !left || !right) return false;
    const RealVector2 along = *out - *in;
    const RealVector2 across = *left - *right;
    return along.x() * across.y() - along.y() * across.x() > 0;
  }

 private:
  static constexpr double kAngleStep = 2e-3;
  static constexpr double kAngleError = 1e-10;
  static constexpr int kNumAzimuths = 48;
  static constexpr double kLookAround = 0.02;  // how much farther out a neighbour of the lowest fold may lie
  static constexpr Real kDifference = 1e-8L;

  static RealVector3 direction(Real angle, Real azimuth) {
    return {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle)};
  }

  // First angle between `from` and `to` at which the lens folds or ends; kMaxAngle without one.
  double foldAlong(double azimuth, double from, double to) const {
    const double end = std::min(to + kAngleStep, M::kMaxAngle * (1 - 1e-12));
    for (double good = from; good < end;) {
      const double angle = std::min(good + kAngleStep, end);
      if (keepsItsSide(angle, azimuth)) {
        good = angle;
        continue;
      }
      double bad = angle;
      while (bad - good > kAngleError) {
        const double middle = 0.5 * (good + bad);
        (keepsItsSide(middle, azimuth) ? good : bad) = middle;
      }
      return good;
    }
    return M::kMaxAngle;
  }

  void followDip(double azimuth, double reach, double fold) {
    constexpr int kNumNeighbours = 8;  // on each side
    while (reach > 1e-7) {
      double best = azimuth;
      for (int i = -kNumNeighbours; i <= kNumNeighbours; ++i) {
        const double here = azimuth + reach * i / kNumNeighbours;
        const double angle = foldAlong(here, std::max(0.0, fold - kLookAround), fold);
        if (angle >= fold) continue;
        fold = angle;
        best = here;
      }
      azimuth = best;
      reach *= 2.0 / kNumNeighbours;
    }
    max_angle_ = std::min(max_angle_, fold);
  }

  const double* lens_;
  double max_angle_ = M::kMaxAngle;
};

}  // namespace alidade
