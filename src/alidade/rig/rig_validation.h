// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/record/rig_record.h"
#include "alidade/rig/rig_calibrator.h"
#include "alidade/target/board.h"

namespace alidade {

/// A camera of a rig under test.
struct TestedRigCamera {
  std::string name;
  double rms_px = 0;        ///< with lenses and poses as stated
  double freed_rms_px = 0;  ///< with the poses of the cameras freed
  SE3 freed_from_stated;    ///< of camera frames; none for the first camera
  /// By which points at the boards' distance, seen by another camera, move in this one's image: median.
  double effect_px = 0;
  /// The standard normal variable that is exceeded as often as this difference of poses by chance.
  double sigmas = 0;
};

/// How a rig agrees with images that it was perhaps not made from.
struct RigValidation {
  std::vector<TestedRigCamera> cameras;
  double rms_px = 0;  ///< with lenses and poses as stated
  double freed_rms_px = 0;
  /// sqrt(mean of dx^2 + dy^2) between pixels of two or more cameras and the point that they give, px.
  double epipolar_px = std::numeric_limits<double>::quiet_NaN();
  std::size_t num_points = 0;  ///< corners that two or more cameras see
  std::size_t num_failed = 0;  ///< of these, without a point
  /// Lengths on the boards as the rig measures them, over those that the boards state; NaN if unknown.
  double length_ratio = std::numeric_limits<double>::quiet_NaN();
  /// From the scatter over frames and the covariance that the rig states.
  double length_ratio_std = std::numeric_limits<double>::quiet_NaN();
  RigCalibration freed;              ///< with the lenses kept
  std::vector<Diagnosis> diagnoses;  ///< failures first

  [[nodiscard]] Verdict verdict() const { return verdictOf(diagnoses); }
};

/// Tests a rig on views of boards: its poses against poses that are freed, its lenses likewise, its epipolar
/// geometry, and the lengths that it measures.
/// @param cameras  in the order of the record
/// @param options  `given` and `models` are not used
/// @throws Error as calibrate()
[[nodiscard]] RigValidation validateRig(const RigRecord& rig, std::span<const Board> boards,
                                        std::vector<RigViews> cameras, const RigOptions& options = {});

}  // namespace alidade
