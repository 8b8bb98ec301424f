// SPDX-License-Identifier: MIT
#include "alidade/footage/follow/tracks.h"

#include <algorithm>
#include <map>

#include "alidade/core/median.h"

namespace alidade {

std::vector<std::pair<std::size_t, std::size_t>> commonTracks(const std::vector<TrackPixel>& a,
                                                              const std::vector<TrackPixel>& b) {
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

FootageTracks withoutFixed(FootageTracks tracks) {
  constexpr double kMotion = 0.0125;  // of the width, by the median track from frame to frame
  constexpr double kStill = 0.002;    // of the width, from the first place of a track
  constexpr int kOften = 2;           // moving frames; a point of the scene may hardly move in one
  struct Stay {
    Eigen::Vector2d first;
    double farthest = 0;
    int num_moving = 0;
  };
  std::map<std::uint32_t, Stay> stays;
  for (std::size_t f = 0; f < tracks.frames.size(); ++f) {
    std::vector<double> motions;
    if (f > 0) {
      for (const auto& [i, j] : commonTracks(tracks.frames[f - 1], tracks.frames[f]))
        motions.push_back((tracks.frames[f][j].pixel - tracks.frames[f - 1][i].pixel).norm());
    }
    const bool is_moving = !motions.empty() && medianOf(std::move(motions)) > kMotion * tracks.size.width;
    for (const TrackPixel& at : tracks.frames[f]) {
      const auto [place, is_new] = stays.try_emplace(at.track, Stay{.first = at.pixel});
      Stay& stay = place->second;
      stay.farthest = std::max(stay.farthest, (at.pixel - stay.first).norm());
      stay.num_moving += is_moving && !is_new ? 1 : 0;
    }
  }
  for (std::vector<TrackPixel>& frame : tracks.frames) {
    std::erase_if(frame, [&](const TrackPixel& at) {
      const Stay& stay = stays.at(at.track);
      return stay.num_moving >= kOften && stay.farthest < kStill * tracks.size.width;
    });
  }
  return tracks;
}

bool isKeyframe(const FootageTracks& kept, const std::vector<TrackPixel>& frame) {
  constexpr double kMotion = 0.04;  // of the width
  constexpr double kShared = 0.5;   // of tracks
  if (frame.empty()) return false;
  if (!kept.is_video || kept.frames.empty()) return true;
  const std::vector<TrackPixel>& last = kept.frames.back();
  std::vector<double> motions;
  for (const auto& [i, j] : commonTracks(last, frame))
    motions.push_back((last[i].pixel - frame[j].pixel).norm());
  if (static_cast<double>(motions.size()) < kShared * static_cast<double>(last.size()) || motions.empty())
    return true;
  return medianOf(std::move(motions)) > kMotion * kept.size.width;
}

std::vector<std::vector<std::size_t>> chooseWindows(const FootageTracks& tracks, std::size_t most) {
  const std::size_t kFrames = tracks.is_video ? 9 : 40;  // of a window
  const std::size_t num_frames = tracks.frames.size();
  if (num_frames < 2) return {};
  // Windows of about equal length.
  const std::size_t count = (num_frames + kFrames - 1) / kFrames;
  std::vector<std::vector<std::size_t>> windows(std::min(count, most));
  for (std::size_t k = 0; k < windows.size(); ++k) {
    const std::size_t w = k * count / windows.size();
    for (std::size_t i = w * num_frames / count; i < (w + 1) * num_frames / count; ++i)
      windows[k].push_back(i);
  }
  return windows;
}

}  // namespace alidade
