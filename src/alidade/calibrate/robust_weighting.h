// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// Huber's threshold in standard deviations of a coordinate: 1.1 % of clean corners lie beyond it.
inline constexpr double kLossSigmas = 3.0;
/// Rounds after which a fit that changes what it is made from has not settled.
inline constexpr int kMaxRounds = 10;

/// Solves for camera, corners' weights and the threshold of the loss together, from where they are.
/// The weights and the loss need the noise and the noise needs a fit: all settle in turn.
void settle(Estimation& estimation);

/// Settles from the loss of a start on, and makes the fit exact.
void solveRobustly(Estimation& estimation);

/// The same from the solution, weights and loss so far.
void settleWeights(Estimation& estimation);

}  // namespace alidade
