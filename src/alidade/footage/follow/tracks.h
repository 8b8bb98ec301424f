// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// One point of a track: where a frame shows it.
struct TrackPixel {
  std::uint32_t track = 0;
  Eigen::Vector2d pixel{0, 0};
  double sigma_px = 1;                ///< standard deviation of each coordinate
  Eigen::Vector2d velocity_px{0, 0};  ///< per frame of the video; zero for photographs
};

/// Points of a scene followed through frames.
struct FootageTracks {
  ImageSize size;
  bool is_video = false;                        ///< frames are equally spaced in time
  std::vector<std::size_t> numbers;             ///< of the frames in their video or list, rising
  std::vector<std::vector<TrackPixel>> frames;  ///< of each frame, in rising order of track

  [[nodiscard]] std::size_t numTracks() const {
    std::size_t most = 0;
    for (const auto& frame : frames) {
      if (!frame.empty()) most = std::max<std::size_t>(most, frame.back().track + 1);
    }
    return most;
  }
};

/// Indices, in both frames, of the tracks that both show.
[[nodiscard]] inline std::vector<std::pair<std::size_t, std::size_t>> commonTracks(
    const std::vector<TrackPixel>& a, const std::vector<TrackPixel>& b) {
  std::vector<std::pair<std::size_t, std::size_t>> common;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i].track < b[j].track) {
      ++i;
    } else if (b[j].track < a[i].track) {
      ++j;
    } else {
      common.emplace_back(i++, j++);
    }
  }
  return common;
}

}  // namespace alidade
