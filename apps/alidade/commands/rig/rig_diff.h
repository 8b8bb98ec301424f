// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "alidade/compare/projection_difference.h"
#include "alidade/files/camera_source.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/pages/comparison_page.h"
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

/// The answer about two cameras or two rigs, and what supports it.
struct DiffResult {
  ComparedPair pair;
  std::string text = {};  ///< for people, with a line end
  json document = {};     ///< for --json
};

/// True if the file has several cameras and states their poses.
[[nodiscard]] bool isRigSource(const CameraSource& source);

/// Compares two rigs. Messages go to standard error unless `common` is quiet.
/// @param of_cameras    for each single camera
/// @param distance_m    of points seen by two cameras; empty: 10 times the baseline
/// @param tolerance_px  largest accepted difference (95 %)
/// @throws Error (kInput) if one is not a rig, or if the cameras do not correspond
[[nodiscard]] DiffResult diffRigs(const CameraSource& a, const CameraSource& b,
                                  const DifferenceOptions& of_cameras, std::optional<double> distance_m,
                                  double tolerance_px, const CommonOptions& common);

}  // namespace alidade
