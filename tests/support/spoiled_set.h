// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "support/simulated_set.h"

namespace alidade {

/// Board and image of all spoiled sets: 70 corners.
inline constexpr Checkerboard kSpoiledBoard{.columns = 10, .rows = 7, .square_m = 0.025};
inline constexpr ImageSize kSpoiledSize{.width = 1280, .height = 960};

/// A camera of about 70 degrees (radtan) or 120 degrees (kannala_brandt).
[[nodiscard]] AnyCamera spoiledCamera(std::string_view model);

/// A clean set of the model's camera, noise of 0.1 px.
[[nodiscard]] SimulatedSet cleanSet(std::string_view model, int num_views, std::uint64_t seed);

/// How corners are moved.
enum class Blunder {
  kAround,  ///< 10 px in a random direction
  kBox,     ///< evenly within +-10 px in x and y
};

/// A corner of a view, as outliers are named.
struct CornerName {
  std::string image;
  int corner_id = 0;
  double moved_px = 0;
};

/// Moves `share` of all corners; returns which.
std::vector<CornerName> moveCorners(SimulatedSet& set, Blunder blunder, double share, std::uint64_t seed);

/// What can be wrong with a whole view.
enum class Spoiler {
  kLargerSquares,  ///< a board with squares 1.2 times as large, at the same place
  kTurned,         ///< numbered from the other end
  kMirrored,       ///< numbered from right to left in each row
  kShifted,        ///< numbered one column on, the last column's corners as the first's
  kColumnsFirst,   ///< numbered along the columns instead of the rows
  kBent,           ///< half of the corners displaced by up to 5 px, rising smoothly from the middle
  kOtherCamera,    ///< by a camera with focal lengths 1.2 times as long
  kFaint,          ///< all corners displaced smoothly by up to 0.5 px
};
[[nodiscard]] std::string_view spoilerName(Spoiler spoiler);

/// Spoils `count` views, spread over the set; returns their names.
std::vector<std::string> spoilViews(SimulatedSet& set, Spoiler spoiler, int count, std::uint64_t seed);

/// A set of a board whose squares are `aspect` times as wide as high while the calibration is told square.
[[nodiscard]] SimulatedSet stretchedSet(std::string_view model, int num_views, double aspect,
                                        std::uint64_t seed);

}  // namespace alidade
