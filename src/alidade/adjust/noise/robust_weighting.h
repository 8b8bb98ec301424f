// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Leverage of each corner: the trace, 0 to 2, of its block of the hat matrix of the weighted fit, with
/// intrinsics and all poses free. The mean squared error of a corner after the fit is (2 - leverage) times
/// the variance of its coordinate; the sum over all corners is the number of free parameters. A few precise
/// corners among poor ones attract the fit, so their small errors do not reflect their noise. 0 for a corner
/// that does not project.
/// @param fit  of one camera
/// @returns one list per view
[[nodiscard]] std::vector<std::vector<double>> leverages(const Fit& fit);

/// Huber's threshold in standard deviations of a coordinate: 1.1 % of clean corners exceed it.
inline constexpr double kLossSigmas = 3.0;
/// Maximum number of rounds of a fit that changes its own weights, after which it counts as not converged.
inline constexpr int kMaxRounds = 10;

/// The standard deviation of a coordinate of a corner of weight 1, as used by the loss, px.
[[nodiscard]] double noiseSigma(const Fit& fit);

/// A fit whose weights and loss were estimated from its residuals.
struct SettledFit {
  Fit fit;
  bool is_settled = true;  ///< weights and loss no longer change
};

/// Iterates the solve and the estimation of corner weights and loss threshold until convergence, because
/// weights and loss depend on the noise, and the noise on a fit. Searches for better poses first.
[[nodiscard]] SettledFit settled(Fit fit, const CancelFlag* cancel);

/// The same without the search for better poses.
[[nodiscard]] SettledFit settledWeights(Fit fit, const CancelFlag* cancel);

/// The same, starting with all weights 1 and the loss of an initial guess.
[[nodiscard]] SettledFit settledFromStart(Fit fit, const CancelFlag* cancel);

}  // namespace alidade
