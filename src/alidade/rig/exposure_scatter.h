// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// Scatter of the times at which the cameras of a rig take the images of one frame.
struct ExposureScatter {
  double std_intervals = 0;  ///< standard deviation, in intervals between frames
  double shift_m = 0;        ///< RMS displacement of the middle of the boards by it and by the delays
  double shift_px = 0;       ///< RMS displacement of their corners in the images
};

}  // namespace alidade
