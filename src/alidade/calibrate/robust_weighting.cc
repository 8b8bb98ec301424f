// SPDX-License-Identifier: MIT
#include "alidade/calibrate/robust_weighting.h"

#include <algorithm>
#include <cmath>

#include "alidade/calibrate/leverage.h"

namespace alidade {
namespace {

// Weights that have not come to rest by then are kept: any weights give an unbiased estimate.
constexpr int kMaxWeightRounds = 6;
constexpr double kLoose = 1e-6;  // of the cost: enough to read the noise off the errors

// A view may have been posed from a camera that was still poor.
bool rightPoses(Estimation& e) {
  PosedCamera camera{.params = e.state.params,
                     .poses = {e.state.camera_from_board.begin(), e.state.camera_from_board.end()}};
  if (!improvePoses(e.options.model, e.board, e.views, e.loss, camera)) return false;
  for (std::size_t v = 0; v < e.views.size(); ++v) e.state.camera_from_board[v] = *camera.poses[v];
  return true;
}

// Weights from the errors of the fit so far; the largest relative change of one.
double updateWeights(Estimation& e) {
  if (e.noise.isUniform()) return 0;
  e.noise.estimateUnexplained(e.observations, e.errors,
                              leverages(e.options.model, e.observations, e.state, e.constraint));
  return weigh(e.noise, e.observations);
}

// The standard deviation of a coordinate of a corner of weight 1 from the median error, which outliers
// hardly move. The error of a clean corner follows Rayleigh's distribution, whose median is
// sqrt(2 ln 2) sigma.
double robustSigma(const Estimation& e) {
  std::vector<double> lengths;
  for (std::size_t v = 0; v < e.errors.size(); ++v) {
    for (std::size_t i = 0; i < e.errors[v].size(); ++i) {
      lengths.push_back(std::sqrt(e.observations[v][i].weight) * e.errors[v][i].norm());
    }
  }
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return std::max(kMinSigmaPx, *middle / std::sqrt(2 * std::log(2.0)));
}

}  // namespace

void settle(Estimation& e) {
  solve(e, kLoose);
  if (rightPoses(e)) solve(e, kLoose);
  settleWeights(e);
}

void settleWeights(Estimation& e) {
  // A change of the threshold or of a weight by 2 % moves no parameter visibly.
  constexpr double kSteady = 0.02;
  e.is_settled = false;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double weight_change = round < kMaxWeightRounds ? updateWeights(e) : 0.0;
    const double threshold = kLossSigmas * robustSigma(e);
    e.is_settled = weight_change < kSteady && std::abs(threshold / e.loss.threshold_px - 1) < kSteady;
    if (e.is_settled) break;
    e.loss.threshold_px = threshold;
    solve(e, kLoose);
  }
  solve(e);
}

void solveRobustly(Estimation& e) {
  e.loss = startLoss(e.views.front().size);
  e.noise = CornerNoise(e.observations);
  settle(e);
}

}  // namespace alidade
