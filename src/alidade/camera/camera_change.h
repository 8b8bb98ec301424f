// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// A way in which a file may be wrong about a camera or its mounting. Its amounts are shares, pixels or
/// radians.
enum class CameraChangeKind : std::uint8_t {
  kFocalLength,     ///< as a share
  kAspect,          ///< fx alone, as a share: the image was stretched
  kPrincipalPoint,  ///< px, in x and in y
  kCenterX,         ///< cx alone, px
  kCenterY,         ///< cy alone, px
  kPixelOrigin,     ///< cx and cy by the same amount, px
  kDistortion,      ///< all coefficients by one factor, minus 1
  kFirstRadial,     ///< the first coefficient of the lens alone
  kRotation,        ///< a camera turned about its centre: rotation vector in its frame, radians
  kPosition,        ///< direction of the baseline, two angles in radians; its length cannot be seen
  kPose,            ///< rotation of the second camera and direction of the baseline
  kSeveral,         ///< all parameters
};
/// "focal_length", "aspect", "principal_point", "cx", "cy", "pixel_origin", "distortion", "radial",
/// "rotation", "position", "pose", "several".
[[nodiscard]] std::string_view changeId(CameraChangeKind kind);

/// Number of amounts of a change; not for kPose and kSeveral.
[[nodiscard]] Eigen::Index numAmounts(CameraChangeKind kind);

/// Derivatives of the parameters by the amounts of a change, one per column; zero for changes of the pose,
/// and for a lens without such a parameter.
/// @param num_params  rows, if more than the camera has
[[nodiscard]] Eigen::MatrixXd directionsOf(CameraChangeKind kind, const AnyCamera& camera,
                                           std::size_t num_params = 0);

/// The camera after a change of its parameters. A pinhole camera becomes a radtan one for kFirstRadial.
/// @returns nothing if a parameter is out of its range
[[nodiscard]] std::optional<AnyCamera> changedCamera(const AnyCamera& camera, CameraChangeKind kind,
                                                     const Eigen::VectorXd& amounts);

/// A camera with these parameters; nothing if one is out of its range.
[[nodiscard]] std::optional<AnyCamera> cameraWith(std::string_view model_id, std::span<const double> params);

}  // namespace alidade
