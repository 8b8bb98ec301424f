// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/geometry/se3.h"

namespace alidade {

/// A pose from a text.
struct NamedPose {
  std::string id{};                ///< from the text; otherwise the index of the pose, from 0
  SE3 camera_from_x{};             ///< transforms points to the camera frame
  SE3 stated{};                    ///< the pose as written, a_from_b
  std::string frames{};            ///< "a_from_b"; empty if unknown
  bool has_translation = true;     ///< otherwise only a rotation was given
  double quaternion_length = 1.0;  ///< as written
};

/// A way to write a pose, or only its rotation, as numbers: "quaternion_xyzw", "euler_zyx_deg".
struct PoseForm {
  std::string name;
  std::vector<int> places;  ///< of the numbers, among all that pose_forms.cc derives from a pose
  std::size_t num_angles;   ///< how many of them are angles, at the end
  const char* help;

  [[nodiscard]] bool hasTranslation() const { return places.size() == 7 || places.size() > 9; }
  /// The stated pose of one number per place. @throws Error (kInput) naming the fault
  [[nodiscard]] NamedPose read(std::span<const double> numbers) const;
  /// @param gimbal_lock  set to true if Euler angles are not determined
  [[nodiscard]] std::vector<double> write(const SE3& pose, bool& gimbal_lock) const;
};

/// All forms; of Euler angles only the order zyx.
[[nodiscard]] const std::vector<PoseForm>& poseForms();
/// The form of this name, with Euler angles of any order.
[[nodiscard]] std::optional<PoseForm> findPoseForm(const std::string& name);
/// What to write instead of an unknown name.
[[nodiscard]] std::string poseFormAdvice(const std::string& name);

}  // namespace alidade
