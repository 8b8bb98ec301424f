// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/footage/check/explain.h"
#include "alidade/footage/follow/tracks.h"

namespace alidade {

/// The change of a camera that fits the footage best.
struct CameraChange : ChangeFit {
  AnyCamera camera;        ///< the changed camera
  double readout = 0;      ///< that fits best with it, see FootageCheck
  double readout_std = 0;  ///< its standard deviation
};

/// The mean error in a part of the image, for points found without the pixel in question.
struct FootageCell {
  int num_pixels = 0;
  double rms_px = 0;
  Eigen::Vector2d mean_px{0, 0};  ///< projected minus observed
};

/// `blind_px` here is that of focal length and distortion.
struct FootageCheck : FootageOutcome {
  std::vector<CameraChange> changes = {};  ///< changes that were tried
  /// Kinds of which a change of ten times the tolerance would go unnoticed. If the principal point is the
  /// only one, the camera may still be consistent: rotations compensate for most of its displacement.
  std::vector<CameraChangeKind> undetermined = {};
  int num_frames = 0;  ///< in windows
  int num_windows = 0;
  int num_points = 0;
  int num_pixels = 0;
  double holdout_rms_px = 0;  ///< errors of pixels not used for their points
  static constexpr int kColumns = 8;
  static constexpr int kRows = 6;
  std::vector<FootageCell> cells = {};  ///< row by row
  double readout = 0;                   ///< of a rolling shutter, in frames; 0 for photographs
  bool is_video = false;
};

/// Tests a camera on footage of a rigid scene. Poses and points are found with the unchanged camera, and then
/// again with one of its properties changed at a time. If freeing all parameters gives a camera far from it
/// that explains more pixels, these pixels are used. The change that removes most of the squared errors is
/// the explanation, if it is significant (1 in 1000) and if a change of ten times the tolerance would be
/// noticed. The camera is inconsistent if the explanation displaces pixels by more than five times the
/// tolerance, and with certainty by more than half of that. All parameters at once must remove a quarter more
/// than that change; or, if that change alone does not make the camera wrong, half of the squared errors,
/// because small track errors common to all images would otherwise be attributed to the lens; and
/// the footage must determine them. Tracks fixed to the image are left out, and there is no verdict with an
/// impossible readout. A camera is called consistent only if at least five frames were reconstructed
/// together.
/// @param tracks  of keyframes
[[nodiscard]] FootageCheck checkOnFootage(const AnyCamera& camera, const FootageTracks& tracks,
                                          const FootageCheckOptions& options = {});

/// "focal length +3.1 % +- 0.2 %".
[[nodiscard]] std::string describe(const CameraChange& change);

}  // namespace alidade
