// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

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

}  // namespace alidade
