// SPDX-License-Identifier: MIT
#include "alidade/adjust/model_comparison.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "alidade/adjust/corner_noise.h"
#include "alidade/core/error.h"
#include "alidade/core/statistics.h"

namespace alidade {
namespace {

// The mean of one number a view, and its standard error by how the views differ.
struct ViewMean {
  double value = 0;
  double std = 0;
  double freedom = 0;

  [[nodiscard]] bool isPositive() const { return freedom > 0 && value > studentTOneSided95(freedom) * std; }
};

ViewMean meanOver(std::span<const double> of_view) {
  const auto n = static_cast<double>(of_view.size());
  double sum = 0;
  for (const double x : of_view) sum += x;
  double scatter = 0;
  for (const double x : of_view) scatter += (x - sum / n) * (x - sum / n);
  return {.value = sum / n, .std = std::sqrt(scatter / (n * (n - 1))), .freedom = n - 1};
}

}  // namespace

double farOff(HuberLoss loss) {
  constexpr double kThresholds = 10;
  const double error_px = kThresholds * loss.threshold_px;
  return loss.rho(error_px * error_px);
}

double noiseFloor(std::size_t num_corners) {
  return 2 * kMinSigmaPx * kMinSigmaPx * static_cast<double>(num_corners);
}

HeldOutScore scoreOf(const HeldOutErrors& errors, const Fit& fit) {
  HeldOutScore score;
  for (std::size_t v = 0; v < errors.px.size(); ++v) {
    double sum = noiseFloor(errors.px[v].size());
    for (std::size_t i = 0; i < errors.px[v].size(); ++i) {
      const Eigen::Vector2d& error = errors.px[v][i];
      const double weight = fit.views[v].corners[i].weight;
      sum += error.allFinite() ? fit.loss.rho(weight * error.squaredNorm()) : farOff(fit.loss);
    }
    score.of_view.push_back(sum);
    score.sum += sum;
  }
  return score;
}

bool HeldOutExcess::isWorth(std::size_t num_further_params) const {
  return is_significant && proven_share > kShareOfParameter * static_cast<double>(num_further_params);
}

HeldOutExcess excessOf(const HeldOutScore& a, const HeldOutScore& b) {
  expect(a.of_view.size() == b.of_view.size(), "two models' errors on the same views");
  std::vector<double> differences;
  std::vector<double> log_ratios;
  for (std::size_t v = 0; v < a.of_view.size(); ++v) {
    if (!(a.of_view[v] > 0 && b.of_view[v] > 0)) continue;  // a view without held-out errors
    differences.push_back(a.of_view[v] - b.of_view[v]);
    log_ratios.push_back(std::log(a.of_view[v] / b.of_view[v]));
  }
  const ViewMean difference = meanOver(differences);
  const auto num_views = static_cast<double>(differences.size());
  const double ratio = std::sqrt(a.sum / b.sum);  // of the RMS
  const ViewMean factor = meanOver(log_ratios);   // of the squares
  const double share = ratio - 1;
  const double by_factor = factor.isPositive() ? std::min(share, std::expm1(0.5 * factor.value)) : 0.0;
  return {.share = share,
          .std = num_views * difference.std / (2 * b.sum * ratio),
          .is_significant = difference.isPositive() || factor.isPositive(),
          .proven_share = difference.isPositive() ? share : by_factor};
}

}  // namespace alidade
