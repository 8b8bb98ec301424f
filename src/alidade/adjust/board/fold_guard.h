// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace ceres {
class CostFunction;
}

namespace alidade {

struct FitCamera;

/// Knowledge that a lens does not fold: along each ray, which points towards a corner of the image beyond the
/// corners of boards, the image must grow outwards. Acts only where it does so less than any real lens, so it
/// changes nothing that corners decide. Empty: no guard.
struct FoldGuard {
  std::vector<Eigen::Vector3d> rays = {};  ///< unit, camera frame, off the axis
  double sigma_px = 1;                     ///< standard deviation of a coordinate of a corner of weight 1

  [[nodiscard]] bool isNone() const { return rays.empty(); }
};

/// Adds rays to the guard of a camera whose lens folds inside the image; false if it does not fold or no ray
/// can help.
/// @param sigma_px  see FoldGuard
[[nodiscard]] bool guardFold(double sigma_px, FitCamera& camera);

/// Half the sum of squares, like the cost of the solver.
[[nodiscard]] double foldGuardCost(const FitCamera& camera);

/// One residual per ray, of the intrinsics, in the unit of the corners' residuals. The guard must outlive it.
/// @param model_id  with parameters at which every ray has a pixel, which a step must not lose
[[nodiscard]] ceres::CostFunction* foldGuardBlock(std::string_view model_id, const FoldGuard& guard);

}  // namespace alidade
