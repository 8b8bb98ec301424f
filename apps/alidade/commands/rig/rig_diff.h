// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/compare/projection_difference.h"
#include "alidade/files/camera_source.h"

namespace alidade {

/// Does the file have several cameras and say where they are?
[[nodiscard]] bool isRigSource(const CameraSource& source);

struct RigDiffRequest {
  DifferenceOptions of_cameras;        ///< for each camera by itself
  std::optional<double> distance_m;    ///< of points seen by two cameras; empty: 10 times the baseline
  std::optional<double> tolerance_px;  ///< largest accepted difference (95 %)
  bool json = false;
  bool quiet = false;
};

/// Compares two rigs, prints the result, and returns the exit code of `alidade diff`.
/// @throws Error (kInput) if one is no rig, or if the cameras do not correspond
[[nodiscard]] int diffRigs(const CameraSource& a, const CameraSource& b, const RigDiffRequest& request);

}  // namespace alidade
