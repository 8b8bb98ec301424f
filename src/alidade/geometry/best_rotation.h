// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "alidade/geometry/so3.h"

namespace alidade {

/// The rotation that takes vectors a_i nearest to vectors b_i, by the weighted sum of the squares of what is
/// between them. Kabsch 1976, A solution for the best rotation to relate two sets of vectors, Acta
/// Crystallographica A32.
/// @param correlation  sum of w_i b_i a_i^T, finite
[[nodiscard]] SO3 bestRotation(const Eigen::Matrix3d& correlation);

}  // namespace alidade
