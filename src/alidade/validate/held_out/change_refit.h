// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/validate/held_out/camera_change.h"
#include "alidade/validate/held_out/held_scores.h"

namespace alidade {

/// What the views are taken for while one change of a camera is estimated, see HeldScores::make().
struct ChangeEvidence {
  const PosedViews* held = nullptr;   ///< posed for the camera as it is
  const PosedViews* freed = nullptr;  ///< the same views, posed for the camera that they give; may be nothing
  double noise_variance = 0;          ///< px^2
  std::optional<DenseMatrix> covariance;  ///< of the tested camera
};

/// A camera changed in one way until nothing more is gained by it.
struct ChangeRefit {
  AnyCamera camera;
  StepEstimate estimate;  ///< of the change in all, its uncertainty that where it has come to rest
  double rms_px = 0;      ///< sqrt(mean of dx^2 + dy^2) over all corners, poses refitted
};

/// Gauss and Newton's steps along one change, with the poses of all views refitted after each: the first step
/// alone, which a score test takes, falls far short where the camera is far off.
/// @returns nothing where the views say nothing of the change, where the way leads to a camera that cannot be
/// or does not see the boards, or where it does not come to rest
[[nodiscard]] std::optional<ChangeRefit> refitChange(const AnyCamera& tested, CameraChange change,
                                                     const ChangeEvidence& evidence);

}  // namespace alidade
