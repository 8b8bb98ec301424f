// SPDX-License-Identifier: MIT
#include "alidade/footage/follow/tracks.h"

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
  std::vector<std::vector<std::size_t>> windows;
  if (tracks.frames.size() < 2) return windows;
  // Windows of about equal length.
  const std::size_t count = (tracks.frames.size() + kFrames - 1) / kFrames;
  for (std::size_t w = 0; w < count; ++w) {
    const std::size_t begin = w * tracks.frames.size() / count;
    const std::size_t end = (w + 1) * tracks.frames.size() / count;
    if (end - begin < 2) continue;
    std::vector<std::size_t>& window = windows.emplace_back();
    for (std::size_t i = begin; i < end; ++i) window.push_back(i);
  }
  if (windows.size() > most) {
    std::vector<std::vector<std::size_t>> fewer;
    for (std::size_t k = 0; k < most; ++k) fewer.push_back(std::move(windows[k * windows.size() / most]));
    return fewer;
  }
  return windows;
}

}  // namespace alidade
