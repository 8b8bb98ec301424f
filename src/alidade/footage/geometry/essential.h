// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "alidade/geometry/se3.h"

namespace alidade {

/// Two rays to one point, of unit length, each in its camera's frame. They may be more than 90 degrees from
/// the axis.
struct RayPair {
  Eigen::Vector3d a;
  Eigen::Vector3d b;
};

/// The essential matrices E with b^T E a = 0 for five pairs of rays: up to ten, of Frobenius norm sqrt(2).
/// E is a combination of four matrices that satisfy the five equations (Nister 2004, An efficient solution to
/// the five-point relative pose problem, PAMI 26(6), section 3); the ten cubic equations for its factors are
/// solved by the eigenvectors of their action matrix (Stewenius, Engels and Nister 2006, Recent developments
/// on direct relative orientation, ISPRS Journal 60(4), section 3).
[[nodiscard]] std::vector<Eigen::Matrix3d> essentialMatrices(const std::array<RayPair, 5>& pairs);

/// [t]x R of b_from_a.
[[nodiscard]] Eigen::Matrix3d essentialMatrix(const SE3& b_from_a);

/// The four motions b_from_a with a translation of length 1 with this essential matrix, up to sign.
[[nodiscard]] std::array<SE3, 4> motionsOf(const Eigen::Matrix3d& essential);

/// Distances along both rays at which these are nearest to each other; negative if they meet behind a camera,
/// infinite or NaN for parallel rays.
[[nodiscard]] Eigen::Array2d depthsOf(const RayPair& pair, const SE3& b_from_a);

}  // namespace alidade
