// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace alidade {

/// The entrance pupil of a lens, which moves with the field angle: the ray at the angle theta (rad) from the
/// optical axis starts on the axis at s(theta) = s1 theta^2 + s2 theta^4, metres, positive towards the scene.
/// That of a fisheye lens moves by millimetres (Gennery 2006, Generalized camera calibration including
/// fish-eye lenses, IJCV 68(3), section 2). Far points do not see it.
struct EntrancePupil {
  static constexpr std::array<std::string_view, 2> kNames = {"s1", "s2"};
  static constexpr std::size_t kSize = kNames.size();

  double s1_m = 0;
  double s2_m = 0;

  friend bool operator==(const EntrancePupil&, const EntrancePupil&) = default;
  [[nodiscard]] bool isFixed() const { return s1_m == 0 && s2_m == 0; }
  /// Where a ray starts on the axis, metres.
  [[nodiscard]] double at(double angle_rad) const {
    const double angle2 = angle_rad * angle_rad;
    return angle2 * (s1_m + angle2 * s2_m);
  }
  /// Describes for a message what s1 or s2 must be. std::nullopt if `value` is valid.
  [[nodiscard]] static std::optional<std::string> complaint(double value_m);
  /// @throws Error (kInput) for a number that is not finite or larger than that of any lens
  void validate() const;
};

}  // namespace alidade
