// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "alidade/adjust/scene/scene_fit.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/footage/geometry/two_view.h"

namespace alidade {

/// A few frames with their poses and points. The world is the first frame's camera; the scale is arbitrary.
struct Reconstruction {
  /// Reason why there is no fit, kRotation or kNone; otherwise the kind of its first two views.
  TwoViewKind kind = TwoViewKind::kNone;
  std::optional<SceneFit> fit;
  std::vector<std::size_t> frames;  ///< of the tracks, those of the fit, ascending
  double noise_px = 0;              ///< standard deviation of a coordinate, from the remaining errors
  double outlier_share = 0;         ///< of the pixels of tracks in these frames
  double parallax_px = 0;           ///< of the first two views
};

/// Starts from the two frames with the most common tracks and a large parallax, adds frames one by one, and
/// adjusts all poses and points. Pixels that do not fit are left out.
/// @param frames  of the tracks, ascending
[[nodiscard]] Reconstruction reconstruct(const AnyCamera& camera, const FootageTracks& tracks,
                                         std::span<const std::size_t> frames,
                                         const CancelFlag* cancel = nullptr);

/// Groups of frames, each reconstructed separately.
struct FootageWindows {
  std::vector<Reconstruction> windows;      ///< with fits
  std::vector<Reconstruction> without_fit;  ///< reasons why others failed
};
/// Reconstructs all groups from chooseWindows(). The rest of a group of photographs becomes further windows.
[[nodiscard]] FootageWindows reconstructAll(const AnyCamera& camera, const FootageTracks& tracks,
                                            int num_jobs, const CancelFlag* cancel);

/// Solves poses and points of all windows again for their present cameras.
/// @returns false on failure
bool solveWindows(std::vector<Reconstruction>& windows, int num_jobs, const CancelFlag* cancel);

/// The standard deviation of a coordinate in units of sigma_px, from the median of the errors.
[[nodiscard]] double noiseOf(const SceneFit& fit);

/// Removes sightings with an error above a limit, in units of sigma_px, then points with fewer than two.
/// Indices of points do not change.
void removeOutliers(SceneFit& fit, double limit);

}  // namespace alidade
