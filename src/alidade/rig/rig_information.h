// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/reduced.h"
#include "alidade/rig/rig_uncertainty.h"

namespace alidade {

/// The normal equations of each frame with the boards' placements eliminated, with the columns of
/// rigColumns(). Frames are independent of each other, views of one frame are not.
[[nodiscard]] std::vector<Reduced> rigInformation(const Fit& fit, const RigColumns& columns);

/// What of these columns is free, one direction per column. Those of each lens are combined so that its
/// corners know each equally well: a lens with parameters that nearly make up for each other would leave no
/// accuracy for the rig as a whole.
/// @param information  with these columns
[[nodiscard]] Eigen::MatrixXd rigDirections(const Fit& fit, const RigColumns& columns,
                                            const Eigen::MatrixXd& information);

}  // namespace alidade
