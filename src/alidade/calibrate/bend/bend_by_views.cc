// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bend/bend_by_views.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "alidade/adjust/view_shares.h"
#include "alidade/core/statistics.h"

namespace alidade {

std::optional<BendByViews> bendByViews(const ShapeInformation& information, const Eigen::Vector2d& bend_m,
                                       const Eigen::MatrixXd& directions, double mean_slope) {
  constexpr double kFewest = 2;  // degrees of freedom; below, not even a strong bend would be significant
  const auto shares =
      ViewShares::make(information.pulls, withBend(directions), mean_slope, information.prior);
  if (!shares) return std::nullopt;
  const Eigen::MatrixXd bend = shares->basis().bottomRows<kNumBends>();
  const Eigen::Vector2d freedoms(shares->freedomOf(bend.row(0).transpose()),
                                 shares->freedomOf(bend.row(1).transpose()));
  BendByViews result{.freedom = freedoms.minCoeff()};
  if (!(result.freedom > kFewest)) return std::nullopt;
  const Eigen::Matrix2d covariance = bend * shares->covariance() * bend.transpose();
  const double t2 = bend_m.dot(covariance.inverse() * bend_m);
  const double n = result.freedom;
  result.f = (n - 1) / (2 * n) * t2;
  result.chance = std::pow(1 + t2 / n, -0.5 * (n - 1));  // F with 2 degrees above has it in closed form
  for (int i = 0; i < kNumBends; ++i)
    result.std_m(i) = std::sqrt(covariance(i, i)) * studentT95(freedoms(i)) / kNormal95;
  return result;
}

bool isBent(double f, const std::optional<BendByViews>& by_views) {
  constexpr double kChance = 0.05;  // it comes on top of kBendF, which a flat board hardly ever exceeds
  return f > kBendF && !(by_views && by_views->chance > kChance);
}

}  // namespace alidade
