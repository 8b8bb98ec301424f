// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_covariance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "alidade/adjust/noise/view_shares.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

double inflation(double freedom) {
  return studentT95(freedom) / kNormal95;
}

// In every direction the larger of two covariances, the first of which is `variance` times the identity.
Eigen::MatrixXd larger(double variance, const Eigen::MatrixXd& covariance) {
  const SymmetricEigen solver(covariance);
  const Eigen::VectorXd values = solver.eigenvalues().cwiseMax(variance);
  return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

std::optional<ViewCovariance> viewCovariance(std::span<const Reduced> pulls,
                                             const Eigen::MatrixXd& directions, int num_params,
                                             double variance, double mean_slope) {
  constexpr std::size_t kFewestViews = 3;  // two always disagree
  constexpr double kLeastFreedom = 2;      // with less, no factor is large enough
  const Eigen::Index m = directions.cols();
  if (m == 0 || pulls.size() < kFewestViews) return std::nullopt;
  const auto shares = ViewShares::make(pulls, directions, mean_slope);
  if (!shares) return std::nullopt;
  const Eigen::MatrixXd& meat = shares->covariance();

  ViewCovariance result;
  const Eigen::MatrixXd root = shares->basis().topRows(num_params);
  result.covariance = root * meat * root.transpose();
  double most = 1;
  for (int i = 0; i < num_params; ++i) {
    result.freedom.push_back(shares->freedomOf(root.row(i).transpose()));
    if (result.covariance(i, i) > 0) most = std::max(most, inflation(result.freedom.back()));
  }
  const auto num_free = static_cast<double>(m);
  result.excess = meat.trace() / (num_free * variance);
  result.excess_sigmas = normalOfMeanSquare(result.excess, num_free * num_free / shares->squaresOfShares());
  result.is_pooled = static_cast<Eigen::Index>(pulls.size()) <= m || !std::isfinite(most);
  if (result.is_pooled) {
    const auto most_freedom = static_cast<double>(pulls.size()) - 1;
    const double freedom = std::clamp(num_free / shares->squaresOfShares() - 1, kLeastFreedom, most_freedom);
    const double pooled = inflation(freedom) * inflation(freedom) * result.excess;
    const double capped = inflation(kLeastFreedom) * inflation(kLeastFreedom);
    result.larger = root * larger(variance * std::max(1.0, pooled), capped * meat) * root.transpose();
  } else {
    result.larger = root * larger(variance, most * most * meat) * root.transpose();
  }
  return result;
}

}  // namespace alidade
