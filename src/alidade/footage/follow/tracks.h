// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// Position of a tracked point in one frame.
struct TrackPixel {
  std::uint32_t track = 0;
  Eigen::Vector2d pixel{0, 0};
  double sigma_px = 1;                ///< standard deviation of each coordinate
  Eigen::Vector2d velocity_px{0, 0};  ///< per frame of the video; zero for photographs
};

/// Points of a scene tracked through frames.
struct FootageTracks {
  ImageSize size;
  bool is_video = false;                        ///< frames are equally spaced in time
  std::vector<std::size_t> numbers;             ///< of the frames in their video or list, ascending
  std::vector<std::vector<TrackPixel>> frames;  ///< of each frame, in ascending order of track
};

/// Indices, in both frames, of their common tracks.
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> commonTracks(const std::vector<TrackPixel>& a,
                                                                            const std::vector<TrackPixel>& b);

/// Without tracks that stay where they are while most others move, as those of a car's bonnet, of dirt on the
/// lens or of a caption do. If the camera does not turn, very distant points go as well.
[[nodiscard]] FootageTracks withoutFixed(FootageTracks tracks);

/// True if a frame shows something new: points moved by 4 % of the width since the last keyframe, or half of
/// them are new. Always true for photographs.
/// @param kept  the keyframes so far
[[nodiscard]] bool isKeyframe(const FootageTracks& kept, const std::vector<TrackPixel>& frame);

/// Groups of keyframes to be reconstructed together. Photographs are one group.
/// @param tracks  of keyframes
/// @param most  groups; if there are more, an even selection
[[nodiscard]] std::vector<std::vector<std::size_t>> chooseWindows(const FootageTracks& tracks,
                                                                  std::size_t most);

}  // namespace alidade
