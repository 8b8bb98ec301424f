// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// Huber's threshold in standard deviations of a coordinate: 1.1 % of clean corners lie beyond it.
inline constexpr double kLossSigmas = 3.0;
/// Rounds after which a fit that changes what it is made from has not settled.
inline constexpr int kMaxRounds = 10;

/// Solves for camera, corners' weights and the threshold of the loss together. The weights and the loss need
/// the noise and the noise needs a fit: all settle in turn, and only then is the fit made exact.
void solveRobustly(Estimation& estimation);

}  // namespace alidade
