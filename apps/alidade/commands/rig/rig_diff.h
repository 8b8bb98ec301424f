// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/compare/projection_difference.h"
#include "alidade/files/camera_source.h"
#include "flags.h"

namespace alidade {

/// The difference of two lenses.
struct LensComparison {
  ComparedCamera a;  ///< both point to the compared cameras
  ComparedCamera b;
  ProjectionDifference difference;
  std::optional<DifferenceSignificance> significance;

  /// True if there are numbers to show.
  [[nodiscard]] bool isKnown() const { return difference.num_compared > 0 && difference.is_converged; }
};
[[nodiscard]] LensComparison compareLenses(const CameraRecord& a, const CameraRecord& b,
                                           const DifferenceOptions& options);

/// True if the file has several cameras and states their poses.
[[nodiscard]] bool isRigSource(const CameraSource& source);

/// Compares two rigs, prints the result, and returns the exit code of `alidade diff`.
/// @param of_cameras    for each single camera
/// @param distance_m    of points seen by two cameras; empty: 10 times the baseline
/// @param tolerance_px  largest accepted difference (95 %)
/// @throws Error (kInput) if one is not a rig, or if the cameras do not correspond
[[nodiscard]] int diffRigs(const CameraSource& a, const CameraSource& b, const DifferenceOptions& of_cameras,
                           std::optional<double> distance_m, std::optional<double> tolerance_px,
                           const CommonOptions& common);

}  // namespace alidade
