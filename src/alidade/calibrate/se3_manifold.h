// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include <ceres/manifold.h>

#include "alidade/geometry/se3.h"

namespace alidade {

/// A pose as the solver holds it: [qx qy qz qw tx ty tz], metres.
using PoseBlock = std::array<double, 7>;

[[nodiscard]] PoseBlock toBlock(const SE3& pose);
[[nodiscard]] SE3 fromBlock(const double* block);

/// SE(3) for Ceres with this project's tangent: T Exp(xi), xi = [translation, rotation] in metres and true
/// radians (Ceres' own quaternion manifolds use half angles, which would make every rotation variance a
/// quarter).
class SE3Manifold final : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override { return 7; }
  [[nodiscard]] int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

}  // namespace alidade
