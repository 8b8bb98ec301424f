// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/validate/held_out/held_scores.h"

namespace alidade {

/// Ways in which intrinsics are wrong as a whole, one number saying by how much: a file of another zoom or
/// focus, of a crop, of a lens like it, or with the pixel's origin at its corner.
enum class CameraChange {
  kFocalLength,  ///< fx and fy times 1 + amount
  kCenterX,      ///< cx + amount, px
  kCenterY,      ///< cy + amount, px
  kDistortion,   ///< every coefficient of the lens times 1 + amount: of models whose 0 is no distortion
  kPixelOrigin,  ///< cx and cy + amount, px
};
inline constexpr std::array kAllCameraChanges = {CameraChange::kFocalLength, CameraChange::kCenterX,
                                                 CameraChange::kCenterY, CameraChange::kDistortion,
                                                 CameraChange::kPixelOrigin};

/// The change of the parameters per amount of 1; empty for a camera that has nothing of the kind.
[[nodiscard]] Eigen::VectorXd directionOf(CameraChange change, const AnyCamera& camera);

/// The camera changed by `amount`; nothing where its parameters would leave their range.
[[nodiscard]] std::optional<AnyCamera> changed(const AnyCamera& camera, CameraChange change, double amount);

/// What is wrong with a camera that would have to be changed by `amount`, in words: "its focal length is
/// 1.02 +- 0.05 % too long".
[[nodiscard]] std::string complaintOf(CameraChange change, double amount, double std);

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
