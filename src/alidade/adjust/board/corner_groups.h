// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "alidade/adjust/board/observation.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// As many corners as there are lanes, coordinate by coordinate.
struct CornerGroup {
  using Column = std::array<double, kNumLanes>;
  Column x, y, z;      ///< of the board point
  Column u, v;         ///< of the pixel
  Column root_weight;  ///< 0 in the padding of a view's last group
  double radius_m;     ///< of the discs, the same for all; 0 for points
};

/// The corners of views in groups. The last group of a view is padded with copies of its first corner, which
/// have weight 0 and project wherever the view does.
class CornerGroups {
 public:
  explicit CornerGroups(std::span<const std::vector<Observation>> views);
  explicit CornerGroups(std::span<const Observation> view);

  [[nodiscard]] std::span<const CornerGroup> view(std::size_t v) const {
    return std::span(groups_).subspan(first_[v], first_[v + 1] - first_[v]);
  }

 private:
  void add(std::span<const Observation> view);

  std::vector<CornerGroup> groups_;
  std::vector<std::size_t> first_ = {0};  // first group of each view, and one past the last group
};

}  // namespace alidade
