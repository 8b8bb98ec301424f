// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/compare/projection_difference.h"
#include "alidade/files/camera_source.h"
#include "flags.h"

namespace alidade {

/// The difference of two lenses.
struct LensComparison {
  ComparedCamera a;  ///< these point to what was compared
  ComparedCamera b;
  ProjectionDifference difference;
  std::optional<DifferenceSignificance> significance;

  /// Whether there are figures to show.
  [[nodiscard]] bool isKnown() const { return difference.num_compared > 0 && difference.is_converged; }
};
[[nodiscard]] LensComparison compareLenses(const CameraRecord& a, const CameraRecord& b,
                                           const DifferenceOptions& options);

/// Does the file have several cameras and say where they are?
[[nodiscard]] bool isRigSource(const CameraSource& source);

/// Compares two rigs, prints the result, and returns the exit code of `alidade diff`.
/// @param of_cameras    for each camera by itself
/// @param distance_m    of points seen by two cameras; empty: 10 times the baseline
/// @param tolerance_px  largest accepted difference (95 %)
/// @throws Error (kInput) if one is no rig, or if the cameras do not correspond
[[nodiscard]] int diffRigs(const CameraSource& a, const CameraSource& b, const DifferenceOptions& of_cameras,
                           std::optional<double> distance_m, std::optional<double> tolerance_px,
                           const CommonOptions& common);

}  // namespace alidade
