// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include <Eigen/Core>

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// Fills in what the corners and the views say of the parameters' uncertainty: covariances, information, the
/// sigmas of the board's bend, and the weak prior that they are under.
/// @param directions  what is free of the parameters, see freeDirections()
/// @param variance    of the coordinate of a corner of weight 1, px^2; infinite if unknown
/// @param weighted_errors  see weightedErrors()
void setCovariances(const Estimation& estimation, const Eigen::MatrixXd& directions, double variance,
                    std::span<const Eigen::Vector2d> weighted_errors, CalibrationResult& result);

}  // namespace alidade
