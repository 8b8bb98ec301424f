// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/validate/held_out/held_scores.h"

namespace alidade {

/// A slip that a camera file may contain, and the camera without it.
struct Slip {
  std::string_view id;  ///< stable, for scripts: "k1_sign"
  std::string text;     ///< with the numbers: "k1 has the wrong sign: k1 -0.28 instead of 0.28"
  AnyCamera mended;
  int num_free = 0;   ///< numbers of the corrected camera that were taken from the images
  double rms_px = 0;  ///< sqrt(mean of dx^2 + dy^2) over all corners, poses refitted to the mended camera
};

/// Corrects each slip of the list that the numbers of a camera allow. Numbers that the slip leaves open, such
/// as a wrong fy, come from the freed camera; otherwise only poses are fitted.
/// @param freed  posed with the camera calibrated from the views
/// @returns those with which all corners can be seen
[[nodiscard]] std::vector<Slip> mendedSlips(const AnyCamera& tested, const PosedViews& freed);

}  // namespace alidade
