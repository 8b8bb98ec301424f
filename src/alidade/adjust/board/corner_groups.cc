// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/corner_groups.h"

#include <cmath>

namespace alidade {
namespace {

std::size_t numGroups(std::size_t num_corners) {
  return (num_corners + kNumLanes - 1) / kNumLanes;
}

}  // namespace

CornerGroups::CornerGroups(std::span<const std::vector<Observation>> views) {
  std::size_t num_groups = 0;
  for (const auto& view : views) num_groups += numGroups(view.size());
  groups_.reserve(num_groups);
  first_.reserve(views.size() + 1);
  for (const auto& view : views) add(view);
}

CornerGroups::CornerGroups(std::span<const Observation> view) {
  groups_.reserve(numGroups(view.size()));
  add(view);
}

void CornerGroups::add(std::span<const Observation> view) {
  for (std::size_t i = 0; i < view.size(); i += kNumLanes) {
    CornerGroup& group = groups_.emplace_back();
    group.radius_m = view[i].radius_m;
    for (std::size_t l = 0; l < kNumLanes; ++l) {
      const bool is_corner = i + l < view.size();
      const Observation& corner = view[is_corner ? i + l : 0];
      group.x[l] = corner.p_board.x();
      group.y[l] = corner.p_board.y();
      group.z[l] = corner.p_board.z();
      group.u[l] = corner.pixel.x();
      group.v[l] = corner.pixel.y();
      group.root_weight[l] = is_corner ? std::sqrt(corner.weight) : 0.0;
    }
  }
  first_.push_back(groups_.size());
}

}  // namespace alidade
