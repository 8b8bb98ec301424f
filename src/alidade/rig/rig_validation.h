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
  /// Displacement in this camera's image, by the two poses, of the boards' points that another camera sees
  /// as well (95 %).
  double effect_px = 0;
  /// Standard normal variable that chance exceeds as often as this difference of poses; NaN if unknown.
  double sigmas = 0;
};

/// Agreement of a rig with images that it may not have been made from.
struct RigValidation {
  double tolerance_px = 0;
  std::vector<TestedRigCamera> cameras;
  double rms_px = 0;  ///< with lenses and poses as stated
  double freed_rms_px = 0;
  /// RMS over pairs of pixels of one point, see epipolarDistance().
  double epipolar_px = std::numeric_limits<double>::quiet_NaN();
  std::size_t num_points = 0;  ///< corners that two or more cameras see
  std::size_t num_failed = 0;  ///< of these, without a triangulated point
  /// Lengths on the boards as measured by the rig, over the stated ones; NaN if unknown.
  double length_ratio = std::numeric_limits<double>::quiet_NaN();
  /// From the scatter between frames and the stated covariance of the rig.
  double length_ratio_std = std::numeric_limits<double>::quiet_NaN();
  RigCalibration freed;              ///< with the given lenses kept
  std::vector<Diagnosis> diagnoses;  ///< failures first

  [[nodiscard]] Verdict verdict() const { return verdictOf(diagnoses); }
};

/// Default tolerance. With a joint covariance, what chance explains is already counted. Without one, the
/// error of the rig's own calibration may reach this.
[[nodiscard]] inline double rigTolerancePx(const RigRecord& rig) {
  return rig.covariance.empty() ? 1 : 0.25;
}

/// Tests a rig on views of boards: its poses and lenses against freed ones, its epipolar geometry, and the
/// lengths that it measures.
/// @param cameras  in the order of the record
/// @param options  `given` and `models` are not used
/// @param tolerance_px  accepted effect of a difference (95 %), px
/// @throws Error as calibrate()
[[nodiscard]] RigValidation validateRig(const RigRecord& rig, std::span<const Board> boards,
                                        std::vector<RigViews> cameras, double tolerance_px,
                                        const RigOptions& options = {});

}  // namespace alidade
