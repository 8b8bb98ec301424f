// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/fit.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Huber's threshold in standard deviations of a coordinate: 1.1 % of clean corners lie beyond it.
inline constexpr double kLossSigmas = 3.0;
/// Rounds after which a fit that changes what it is made from has not settled.
inline constexpr int kMaxRounds = 10;

/// One standard deviation of the coordinate of a corner of weight 1, as the loss has it, px.
[[nodiscard]] double noiseSigma(const Fit& fit);

/// A fit whose weights and loss come from its own errors.
struct SettledFit {
  Fit fit;
  bool is_settled = true;  ///< what it is made from changes no more
};

/// Solves for camera, corners' weights and the threshold of the loss together, from where they are: the
/// weights and the loss need the noise and the noise needs a fit. Looks for better poses first.
[[nodiscard]] SettledFit settled(Fit fit, const CancelFlag* cancel);

/// The same without looking for better poses.
[[nodiscard]] SettledFit settledWeights(Fit fit, const CancelFlag* cancel);

/// The same from weights that are all 1 and the loss of a start.
[[nodiscard]] SettledFit settledFromStart(Fit fit, const CancelFlag* cancel);

}  // namespace alidade
