// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "alidade/core/lanes.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// How six rows of numbers lie in memory that belong to the pose of a view: a column each for the pose's
/// tangent, the parameters and the error. What comes after the pose starts a new group of lanes, and so does
/// a row.
struct PoseRowLayout {
  static constexpr std::size_t kPose = 6;
  static constexpr std::size_t kShared =
      (kPose + kNumLanes - 1) / kNumLanes * kNumLanes;  ///< where it starts

  static constexpr std::size_t stride(int num_params) {
    const std::size_t num_shared = static_cast<std::size_t>(num_params) + 1;
    return kShared + (num_shared + kNumLanes - 1) / kNumLanes * kNumLanes;
  }
  /// Numbers a view.
  static constexpr std::size_t size(int num_params) { return kPose * stride(num_params); }
};

/// Takes the poses out of the normal equations of a bundle of views and gives their steps back, for cameras
/// of some number of parameters. Poses are damped as by Levenberg and Marquardt: A, the part of the normal
/// equations that is the pose's own, becomes A + damping diag(A).
class PoseElimination {
 public:
  virtual ~PoseElimination() = default;

  /// @param equations  of view after view: the pose's rows of [J r]^T [J r], as PoseRowLayout says
  /// @param damping  at least kMinDamping
  /// @param factors  of the same size: Cholesky's factor of the damped pose part, R^T R, and R^-T times the
  ///                 other columns
  /// @param schur  the sums of [J r]^T [J r] over all views in the columns of parameters and error, lower
  ///               triangle; less what the poses take from them
  virtual void eliminate(std::span<const double> equations, double damping, std::span<double> factors,
                         Eigen::MatrixXd& schur) const = 0;

  /// Moves the poses by the step that minimises the damped equations, `share` of it, and by what follows when
  /// the parameters step.
  virtual void step(std::span<const double> factors, double share, std::span<const double> params_step,
                    std::span<const SE3> from, std::span<SE3> to) const = 0;
};

/// Far above rounding, so that no pose is singular, and far below what would slow the solver down.
inline constexpr double kMinDamping = 1e-12;

/// For the number of parameters of a model that there is.
[[nodiscard]] const PoseElimination& poseElimination(int num_params);

}  // namespace alidade
