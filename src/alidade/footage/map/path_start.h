// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/footage/geometry/two_view.h"
#include "alidade/footage/map/local_map.h"

namespace alidade {

/// Reason why no segment could be started.
enum class StartObstacle : std::uint8_t {
  kNone,
  kFewPoints,  ///< the frames share too few points
  kStill,      ///< nothing moves
  kRotation,   ///< points move as if the camera turned in place
  kNoMotion,   ///< points move, but not like one rigid scene
};
/// "none", "few_points", "still", "rotation", "no_motion".
[[nodiscard]] std::string_view obstacleId(StartObstacle obstacle);

/// A frame that is waiting for its pose.
struct WaitingFrame {
  std::size_t index = 0;  ///< into Path::frames
  std::vector<TrackPixel> tracks;
};

/// Collects frames until two of them show the camera's motion.
class PathStart {
 public:
  PathStart(const AnyCamera& camera, ImageSize size, const SightScale& scale);

  /// Takes a frame. @returns the motion from the oldest to the newest waiting frame once it can be estimated;
  /// its points are those of commonTracks() of the two
  [[nodiscard]] std::optional<TwoView> add(std::size_t index, std::span<const TrackPixel> tracks);
  /// Accepts a smaller parallax than add(): at the end of the footage no better pair will come.
  [[nodiscard]] std::optional<TwoView> lastChance();
  /// True if a frame shares too little with the previous one to continue.
  [[nodiscard]] bool isCutOff(std::span<const TrackPixel> tracks) const;

  /// Rejects a motion that gave no poses for the frames between, and waits for a larger parallax.
  void reject();
  [[nodiscard]] const std::deque<WaitingFrame>& waiting() const { return waiting_; }
  /// Frames before the waiting ones, with which they share too few points.
  [[nodiscard]] const std::deque<WaitingFrame>& earlier() const { return earlier_; }
  [[nodiscard]] StartObstacle obstacle() const { return obstacle_; }

 private:
  [[nodiscard]] std::optional<TwoView> tryPair(double least_rad, double sure_rad);
  std::nullopt_t failed(StartObstacle obstacle);
  void forgetUnconnected();

  const AnyCamera& camera_;
  ImageSize size_;
  const SightScale& scale_;
  std::deque<WaitingFrame> waiting_;
  std::deque<WaitingFrame> earlier_;
  double wanted_rad_;
  StartObstacle obstacle_ = StartObstacle::kFewPoints;
};

}  // namespace alidade
