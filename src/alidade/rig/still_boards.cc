// SPDX-License-Identifier: MIT
#include "alidade/rig/still_boards.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>

namespace alidade {
namespace {

using Frames = std::set<std::size_t>;

// True if a camera has separate views in several of these frames.
bool isToldApart(const Frames& frames, const Frames& of_camera) {
  return std::ranges::count_if(frames, [&](std::size_t frame) { return of_camera.contains(frame); }) > 1;
}

}  // namespace

std::vector<std::vector<std::size_t>> firstFrames(const RigFrames& frames, std::span<const RigViews> given,
                                                  std::span<const Calibration> alone) {
  std::vector<std::vector<std::size_t>> all(alone.front().fit.boards.size(),
                                            std::vector<std::size_t>(frames.names.size()));
  for (std::size_t b = 0; b < all.size(); ++b) {
    std::vector<std::size_t>& first_of = all[b];
    std::iota(first_of.begin(), first_of.end(), 0);
    std::vector<Frames> together;  // for each frame that is the first of a group
    for (std::size_t frame = 0; frame < first_of.size(); ++frame) together.push_back({frame});
    std::vector<Frames> of_camera(alone.size());
    for (std::size_t c = 0; c < alone.size(); ++c) {
      const Fit& fit = alone[c].fit;
      for (const FitView& view : fit.views) {
        if (boardIndex(fit, view) == b) of_camera[c].insert(frames.frame_of[c][view.source]);
      }
    }
    for (std::size_t c = 0; c < alone.size(); ++c) {
      std::map<std::string, std::size_t> frame_of_image;
      for (std::size_t v = 0; v < given[c].views.size(); ++v)
        frame_of_image[given[c].views[v].image] = frames.frame_of[c][v];
      for (const RepeatedView& repeated : alone[c].dropped.repeated) {
        if (repeated.board != b) continue;
        const std::size_t one = first_of[frame_of_image.at(repeated.image)];
        const std::size_t other = first_of[frame_of_image.at(repeated.same_as)];
        if (one == other) continue;
        Frames both = together[one];
        both.insert(together[other].begin(), together[other].end());
        if (std::ranges::any_of(of_camera, [&](const Frames& own) { return isToldApart(both, own); }))
          continue;
        const std::size_t first = std::min(one, other);
        for (const std::size_t frame : both) first_of[frame] = first;
        together[first] = std::move(both);
      }
    }
  }
  return all;
}

}  // namespace alidade
