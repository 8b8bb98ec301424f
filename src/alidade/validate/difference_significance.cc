// SPDX-License-Identifier: MIT
#include "alidade/validate/difference_significance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Eigenvalues>

#include "alidade/calibrate/distributions.h"
#include "alidade/validate/difference_factor.h"

namespace alidade {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kOneInHundred = 2.3263478740408408;  // a normal variable exceeds it in 1 % of all cases
// Differences below this are rounding, whatever the covariance says.
constexpr double kRoundingPx = 1e-9;

// Mean of squares of which the products' sums are in `gram`, as that of so many independent ones.
double freedomOf(const Eigen::MatrixXd& gram) {
  const double trace = gram.trace();
  return trace > 0 ? std::max(1.0, trace * trace / gram.squaredNorm()) : 1.0;
}

}  // namespace

bool DifferenceSignificance::isSignificant() const {
  return sigmas > kOneInHundred;
}

std::optional<DifferenceSignificance> significanceOf(const ProjectionDifference& difference,
                                                     const ComparedCamera& a, const ComparedCamera& b,
                                                     std::optional<Freed> freed) {
  if ((!a.covariance && !b.covariance) || difference.num_compared == 0) return std::nullopt;
  std::vector<std::size_t> compared;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<double> weights;
  for (std::size_t i = 0; i < difference.pixels.size(); ++i) {
    if (!difference.difference_px[i].allFinite()) continue;
    compared.push_back(i);
    pixels.push_back(difference.pixels[i]);
    weights.push_back(difference.weights[i]);
  }
  Eigen::MatrixXd factor = differenceFactor(a, b, difference.match, pixels, freed, weights);

  const auto n = static_cast<double>(compared.size());
  DifferenceSignificance result;
  result.std_px.assign(difference.pixels.size(), kNan);
  result.expected_rms_px = std::sqrt(factor.squaredNorm() / n);

  std::vector<double> sure_px;
  double sum_of_squares = 0;
  int num_beyond = 0;
  for (std::size_t i = 0; i < compared.size(); ++i) {
    auto rows = factor.middleRows<2>(2 * static_cast<Eigen::Index>(i));
    const Eigen::Matrix2d covariance =
        rows * rows.transpose() + kRoundingPx * kRoundingPx * Eigen::Matrix2d::Identity();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
    result.std_px[compared[i]] = std::sqrt(solver.eigenvalues()(1));
    const Eigen::Vector2d& d = difference.difference_px[compared[i]];
    const double variance_along = d.norm() > 0 ? d.dot(covariance * d) / d.squaredNorm() : 0.0;
    sure_px.push_back(std::max(0.0, d.norm() - 2 * std::sqrt(variance_along)));
    const Eigen::Matrix2d whiten = solver.operatorInverseSqrt();
    rows = (whiten * rows).eval();
    const double squared_sigmas = (whiten * d).squaredNorm();
    sum_of_squares += squared_sigmas;
    constexpr double kEllipse95 = 5.991464547107979;  // of two normal variables' squares
    num_beyond += squared_sigmas > kEllipse95 ? 1 : 0;
  }
  result.sure_p95_px = quantile95(std::move(sure_px));
  result.sigmas = normalOfMeanSquare(sum_of_squares / (2 * n), freedomOf(factor.transpose() * factor));
  result.share_beyond = num_beyond / n;
  return result;
}

}  // namespace alidade
