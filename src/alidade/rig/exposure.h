// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/geometry/se3.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// Scatter of the deviations of views.
struct Scatter {
  double std_intervals = 0;  ///< standard deviation of the times, in intervals between frames
  double path =
      0;  ///< standard deviation about the path, in half the change of velocity between frames for that time
};

/// Lets the board's pose in each view that shares its placement deviate along the board's path, as it does if
/// cameras take a frame at slightly different times, with a delay for each camera but the first and a scatter
/// of the times. The path is that of the present placements.
/// @param times  of frames, in intervals
void followPaths(const Scatter& scatter, std::span<const double> times, Fit& fit);

/// The same with a scatter that covers the differences of the poses from single views.
/// @param rig_from_body  pose of the body from each view alone
/// @returns the scatter; zero if too few views share placements
Scatter startDeviations(const std::vector<SE3>& rig_from_body, std::span<const double> times, Fit& fit);

/// The displacement of boards and corners by the deviations of the views.
[[nodiscard]] ExposureScatter exposureScatter(double std_intervals, const Fit& fit);

}  // namespace alidade
