// SPDX-License-Identifier: MIT
#include "support/spoiled_set.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace alidade {
namespace {

constexpr double kNoisePx = 0.1;

// The corners under other ids: new_id(column, row) of what was at (column, row).
template <class NewId>
void renumber(View& view, const NewId& new_id) {
  for (Corner& corner : view.corners)
    corner.id = new_id(corner.id % kSpoiledBoard.columns, corner.id / kSpoiledBoard.columns);
  std::sort(view.corners.begin(), view.corners.end(),
            [](const Corner& a, const Corner& b) { return a.id < b.id; });
}

void spoil(const SimulatedSet& set, const SE3& pose, Spoiler spoiler, Random& random, View& view) {
  constexpr int kColumns = kSpoiledBoard.columns;
  constexpr int kRows = kSpoiledBoard.rows;
  const auto photographed = [&](const AnyCamera& camera, const Checkerboard& board) {
    view = exactView(camera, set.size, board, pose, view.image);
    addCornerNoise(view, kNoisePx, random);
  };
  switch (spoiler) {
    case Spoiler::kLargerSquares: {
      Checkerboard larger = set.board;
      larger.square_m *= 1.2;
      photographed(set.camera, larger);
      return;
    }
    case Spoiler::kTurned:
      renumber(view, [](int c, int r) { return (kRows - 1 - r) * kColumns + kColumns - 1 - c; });
      return;
    case Spoiler::kMirrored:
      renumber(view, [](int c, int r) { return r * kColumns + kColumns - 1 - c; });
      return;
    case Spoiler::kShifted:
      renumber(view, [](int c, int r) { return r * kColumns + (c + 1) % kColumns; });
      return;
    case Spoiler::kColumnsFirst:
      renumber(view, [](int c, int r) { return c * kRows + r; });
      return;
    case Spoiler::kBent: {
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      const Eigen::Vector2d way(5 * std::cos(angle), 5 * std::sin(angle));
      for (Corner& corner : view.corners) {
        const double column = corner.id % kColumns;
        const double share = (column - 0.5 * (kColumns - 1)) / (0.5 * (kColumns - 1));
        if (share > 0) corner.pixel += std::sqrt(share) * way;
      }
      return;
    }
    case Spoiler::kOtherCamera: {
      std::vector<double> params(set.camera.parameters().begin(), set.camera.parameters().end());
      params[0] *= 1.2;
      params[1] *= 1.2;
      photographed(AnyCamera::make(set.camera.modelId(), params), set.board);
      return;
    }
    case Spoiler::kFaint: {
      const double phase = random.uniform(0, 2 * std::numbers::pi);
      for (Corner& corner : view.corners) {
        const double column = corner.id % kColumns;
        const double row = static_cast<double>(corner.id) / kColumns;
        corner.pixel += 0.5 * Eigen::Vector2d(std::sin(0.5 * column + phase), std::cos(0.7 * row + phase));
      }
      return;
    }
  }
}

}  // namespace

AnyCamera spoiledCamera(std::string_view model) {
  if (model == "kannala_brandt")
    return AnyCamera::make(model, std::vector<double>{603, 601, 645, 475, 0.02, -0.005, 0.001, -2e-4});
  return AnyCamera::make("radtan",
                         std::vector<double>{1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01});
}

SimulatedSet cleanSet(std::string_view model, int num_views, std::uint64_t seed) {
  return simulateSet(spoiledCamera(model), kSpoiledSize, num_views, kNoisePx, seed, {}, kSpoiledBoard);
}

std::vector<CornerName> moveCorners(SimulatedSet& set, Blunder blunder, double share, std::uint64_t seed) {
  constexpr double kReach = 10;
  Random random(seed);
  std::vector<CornerName> moved;
  for (View& view : set.views) {
    for (Corner& corner : view.corners) {
      if (random.uniform() >= share) continue;
      Eigen::Vector2d way(random.uniform(-kReach, kReach), random.uniform(-kReach, kReach));
      if (blunder == Blunder::kAround) {
        const double angle = random.uniform(0, 2 * std::numbers::pi);
        way = {kReach * std::cos(angle), kReach * std::sin(angle)};
      }
      corner.pixel += way;
      moved.push_back({view.image, corner.id, way.norm()});
    }
  }
  return moved;
}

std::string_view spoilerName(Spoiler spoiler) {
  switch (spoiler) {
    case Spoiler::kLargerSquares:
      return "larger_squares";
    case Spoiler::kTurned:
      return "turned";
    case Spoiler::kMirrored:
      return "mirrored";
    case Spoiler::kShifted:
      return "shifted";
    case Spoiler::kColumnsFirst:
      return "columns_first";
    case Spoiler::kBent:
      return "bent";
    case Spoiler::kOtherCamera:
      return "other_camera";
    case Spoiler::kFaint:
      return "faint";
  }
  return "unknown";
}

std::vector<std::string> spoilViews(SimulatedSet& set, Spoiler spoiler, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) {
    const std::size_t v =
        (2 * static_cast<std::size_t>(i) + 1) * set.views.size() / (2 * static_cast<std::size_t>(count));
    spoil(set, set.poses[v], spoiler, random, set.views[v]);
    names.push_back(set.views[v].image);
  }
  return names;
}

SimulatedSet stretchedSet(std::string_view model, int num_views, double aspect, std::uint64_t seed) {
  SimulatedSet set = cleanSet(model, num_views, seed);
  Random random(seed + 1);
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    for (Corner& corner : set.views[v].corners) {
      Eigen::Vector3d p = set.board.corner(corner.id);
      p.x() *= aspect;
      const Eigen::Vector2d noise(random.normal(), random.normal());
      corner.pixel = set.camera.project(set.poses[v] * p).pixel + kNoisePx * noise;
    }
  }
  return set;
}

}  // namespace alidade
