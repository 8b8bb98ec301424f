// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "alidade/core/random.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/simulate/footage_simulator.h"

namespace alidade::testing {

/// Errors of simulated tracks, standard deviations of a coordinate.
struct TrackErrors {
  double noise_px = 0;  ///< of each pixel by itself
  double drift_px = 0;  ///< from frame to frame of one track
};

/// Exact tracks with errors, of keyframes as trackFootage() keeps them.
/// @param points  where tracks begin
inline FootageTracks simulatedTracks(const FootageSimulator& simulator, const TrackErrors& errors,
                                     std::uint64_t seed, const TrackOptions& points = {}) {
  Random random(seed);
  std::vector<std::vector<TrackPixel>> frames(static_cast<std::size_t>(simulator.numFrames()));
  for (const TrueTrack& track : simulator.trackPoints(points)) {
    Eigen::Vector2d drift{0, 0};
    for (std::size_t i = 0; i < track.pixels.size(); ++i) {
      drift += errors.drift_px * Eigen::Vector2d(random.normal(), random.normal());
      TrackPixel at{.track = static_cast<std::uint32_t>(track.id), .pixel = track.pixels[i] + drift};
      at.pixel += errors.noise_px * Eigen::Vector2d(random.normal(), random.normal());
      if (i > 0) at.velocity_px = track.pixels[i] - track.pixels[i - 1];
      frames[static_cast<std::size_t>(track.first_frame) + i].push_back(at);
    }
  }
  FootageTracks kept;
  kept.size = simulator.scene().image_size;
  kept.is_video = true;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!isKeyframe(kept, frames[i])) continue;
    kept.numbers.push_back(i);
    kept.frames.push_back(std::move(frames[i]));
  }
  return kept;
}

}  // namespace alidade::testing
