// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A camera at its place in a rig.
struct MountedCamera {
  std::string name;
  AnyCamera camera;
  ImageSize image_size;
  SE3 camera_from_rig = {};  ///< metres
};

/// A half line in the rig's frame: origin + distance * direction, distance >= 0.
struct RigRay {
  Eigen::Vector3d origin;     ///< on the camera's axis, metres: its centre if its pupil does not move
  Eigen::Vector3d direction;  ///< of unit length
};

/// Cameras that are fixed to each other, with value semantics. The poses define the rig's frame; in Alidade's
/// own files, it is the frame of the first camera.
class AnyRig {
 public:
  /// @throws Error (kInput) without a camera, or if the names are not unique
  explicit AnyRig(std::vector<MountedCamera> cameras);

  [[nodiscard]] std::size_t size() const { return cameras_.size(); }
  [[nodiscard]] const std::vector<MountedCamera>& cameras() const { return cameras_; }
  /// @pre i < size()
  [[nodiscard]] const MountedCamera& camera(std::size_t i) const { return cameras_.at(i); }
  /// The index of a camera. @throws Error (kUsage) for an unknown name, with the known ones
  [[nodiscard]] std::size_t index(std::string_view name) const;

  /// The pixel of a point of the rig's frame (metres) in camera `i`, or why it has none. The pixel may lie
  /// outside the image.
  [[nodiscard]] Projection project(std::size_t i, const Eigen::Vector3d& p_rig) const;
  /// The same in all cameras, in their order.
  [[nodiscard]] std::vector<Projection> project(const Eigen::Vector3d& p_rig) const;
  /// The ray that camera `i` sees at `pixel`; std::nullopt if no ray projects there.
  [[nodiscard]] std::optional<RigRay> unproject(std::size_t i, const Eigen::Vector2d& pixel) const;

 private:
  std::vector<MountedCamera> cameras_;
};

}  // namespace alidade
