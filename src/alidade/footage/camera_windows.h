// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/footage/reconstruction.h"
#include "alidade/footage/tracks.h"

namespace alidade {

/// Whether a frame shows something new: points moved by 4 % of the width since the last one that did, or half
/// of them are new. Photographs always do.
/// @param kept  the frames so far that did
[[nodiscard]] bool isKeyframe(const FootageTracks& kept, const std::vector<TrackPixel>& frame);

/// Keyframes in groups that are reconstructed together.
/// @param tracks  of keyframes
/// @param most  groups; of more, so many are taken evenly
[[nodiscard]] std::vector<std::vector<std::size_t>> chooseWindows(const FootageTracks& tracks, std::size_t most);

/// A camera that was estimated from footage.
struct FreedCamera {
  AnyCamera camera;
  double readout = 0;  ///< see SceneFit::readout
  /// Of the parameters in storage order, then the readout. The points of a scene are taken as independent,
  /// the pixels of one point are not; where windows differ by more than this explains, it is larger by that.
  DenseMatrix covariance;
  DenseMatrix information;  ///< of the same, by the pixels alone; in units of their noise
  DenseMatrix scatter;      ///< covariance of the gradient of the cost that the information belongs to
  std::vector<Reconstruction> windows;  ///< at the camera
  double noise_px = 0;
  double field_px = 0;  ///< standard deviation of the coefficients of the images' error fields
  double disagreement = 1;  ///< of the windows: variance of their gradients over the expected; 1 for one window
  bool is_converged = false;
  bool has_readout = false;  ///< it was free: the footage is a video
};

struct FreeingOptions {
  /// Standard deviation, px, RMS over the pixels of the footage, of the change that is thought possible
  /// before any footage is seen: what footage does not determine then stays as it is.
  double prior_px = 20;
  int num_jobs = 0;
  const CancelFlag* cancel = nullptr;
};

/// Estimates the camera's parameters together with poses and points of all windows: Gauss-Newton steps on the
/// windows' normal equations, each solved for its poses and points with the camera held.
/// @param windows  reconstructed, with fits
/// @returns nothing if no step can be evaluated
[[nodiscard]] std::optional<FreedCamera> freeCamera(const AnyCamera& given, std::vector<Reconstruction> windows,
                                                    const FootageTracks& tracks, const FreeingOptions& options);

}  // namespace alidade
