// SPDX-License-Identifier: MIT
#include "alidade/detect/board/circle_placement.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/median.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr int kMostLines = 100;  // largest board, in each direction

struct PlacedNode {
  int x = 0;
  int y = 0;
  const Blob* blob = nullptr;
};

// Removes nearly empty lines at the ends, which do not belong to the grid.
void trimEnds(std::vector<PlacedNode>& nodes, int PlacedNode::*line_of) {
  constexpr double kMinShare = 0.25;  // share of the typical line
  std::map<int, int> counts;
  for (const PlacedNode& node : nodes) ++counts[node.*line_of];
  std::deque<std::pair<int, int>> lines(counts.begin(), counts.end());
  while (!lines.empty()) {
    std::vector<double> sizes;
    for (const auto& [line, count] : lines) sizes.push_back(count);
    const double typical = medianOf(std::move(sizes));
    const auto isGrid = [&](const auto& line) {
      return line.second >= kMinShare * typical && line.second > 1;
    };
    if (!isGrid(lines.front())) {
      lines.pop_front();
    } else if (!isGrid(lines.back())) {
      lines.pop_back();
    } else {
      break;
    }
  }
  std::erase_if(nodes, [&](const PlacedNode& node) {
    return lines.empty() || node.*line_of < lines.front().first || node.*line_of > lines.back().first;
  });
}

std::optional<GridPlacement> placedOn(std::vector<PlacedNode> nodes, bool is_asymmetric) {
  trimEnds(nodes, &PlacedNode::y);
  trimEnds(nodes, &PlacedNode::x);
  if (nodes.empty()) return std::nullopt;
  const auto [left, right] = std::ranges::minmax(nodes, {}, &PlacedNode::x);
  const auto [top, bottom] = std::ranges::minmax(nodes, {}, &PlacedNode::y);
  const int x0 = left.x;
  const int y0 = top.y;
  const int width = right.x - x0 + 1;
  GridPlacement placement;
  placement.counts = {.is_asymmetric = is_asymmetric,
                      .columns = is_asymmetric ? width / 2 : width,
                      .rows = bottom.y - y0 + 1};
  if (is_asymmetric && width % 2 != 0) return std::nullopt;
  if (std::max(placement.counts.columns, placement.counts.rows) > kMostLines) return std::nullopt;
  for (const PlacedNode& node : nodes) {
    const int x = node.x - x0;
    const int y = node.y - y0;
    if (is_asymmetric && (x + y) % 2 != 0) return std::nullopt;
    const int column = is_asymmetric ? x / 2 : x;
    placement.blobs[y * placement.counts.columns + column] = *node.blob;
  }
  return placement;
}

// The mean step along the columns.
Vector2d columnStep(const GridPlacement& placement) {
  Vector2d sum = Vector2d::Zero();
  for (const auto& [id, blob] : placement.blobs) {
    const auto next = placement.blobs.find(id + 1);
    if ((id + 1) % placement.counts.columns != 0 && next != placement.blobs.end())
      sum += next->second.pixel - blob.pixel;
  }
  return sum;
}

}  // namespace

std::string countsText(const CircleCounts& counts) {
  return fmt::format("{}x{} circles{}", counts.columns, counts.rows,
                     counts.is_asymmetric ? " in an asymmetric grid" : "");
}

std::vector<GridPlacement> gridPlacementsOf(const DiscLattice& lattice) {
  constexpr int kMost = 2;
  constexpr double kMinFilled = 0.6;
  constexpr std::size_t kMostNodes = 11 * kMostLines * kMostLines / 10;  // allows a tenth of other spots
  std::vector<GridPlacement> placements;
  if (lattice.size() > kMostNodes) return placements;
  for (int a = -kMost; a <= kMost; ++a) {
    for (int b = -kMost; b <= kMost; ++b) {
      for (int c = -kMost; c <= kMost; ++c) {
        for (int d = -kMost; d <= kMost; ++d) {
          if (a * d - b * c != 1) continue;
          for (const bool is_asymmetric : {false, true}) {
            std::vector<PlacedNode> nodes;
            for (const LatticeNode& node : lattice) {
              const int i = a * node.i + b * node.j;
              const int j = c * node.i + d * node.j;
              // The steps of an asymmetric grid's lattice are the diagonals of the grid.
              nodes.push_back(is_asymmetric ? PlacedNode{i - j, i + j, &node.blob}
                                            : PlacedNode{i, j, &node.blob});
            }
            auto placement = placedOn(std::move(nodes), is_asymmetric);
            if (placement && placement->filled() >= kMinFilled) placements.push_back(std::move(*placement));
          }
        }
      }
    }
  }
  std::stable_sort(placements.begin(), placements.end(),
                   [](const GridPlacement& x, const GridPlacement& y) { return x.filled() > y.filled(); });
  return placements;
}

const GridPlacement* chosenPlacement(const std::vector<GridPlacement>& placements,
                                     const CircleCounts& asked) {
  const GridPlacement* best = nullptr;
  Vector2d best_step;
  const auto rank = [](const Vector2d& step) {
    if (std::abs(step.x()) >= std::abs(step.y())) return step.x() > 0 ? 3 : 0;
    return step.y() > 0 ? 2 : 1;
  };
  for (const GridPlacement& placement : placements) {
    if (placement.counts != asked) continue;
    const Vector2d step = columnStep(placement);
    const bool is_better = best == nullptr || placement.filled() > best->filled() ||
                           (placement.filled() == best->filled() && rank(step) > rank(best_step));
    if (!is_better) continue;
    best = &placement;
    best_step = step;
  }
  return best;
}

}  // namespace alidade
