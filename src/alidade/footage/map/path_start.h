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

/// Two waiting frames between which the camera moved.
struct StartingPair {
  std::size_t a = 0;  ///< indices into PathStart::waiting()
  std::size_t b = 0;
  TwoView motion;
  std::vector<std::uint32_t> tracks;  ///< of the motion's matches
};

/// Collects frames until two of them show the camera's motion.
class PathStart {
 public:
  PathStart(const AnyCamera& camera, ImageSize size, const SightScale& scale, std::uint64_t seed);

  /// Takes a frame. @returns a pair once one is found
  [[nodiscard]] std::optional<StartingPair> add(std::size_t index, std::span<const TrackPixel> tracks);
  /// Accepts a smaller parallax than add(): at the end of the footage no better pair will come.
  [[nodiscard]] std::optional<StartingPair> lastChance();
  /// True if a frame shares too little with the previous one to continue.
  [[nodiscard]] bool isCutOff(std::span<const TrackPixel> tracks) const;

  /// Reports that the pair did not lead to poses of the frames between; waits for a larger parallax.
  void reject();
  [[nodiscard]] const std::deque<WaitingFrame>& waiting() const { return waiting_; }
  /// Frames before the waiting ones, with which they share too few points.
  [[nodiscard]] const std::deque<WaitingFrame>& earlier() const { return earlier_; }
  [[nodiscard]] StartObstacle obstacle() const { return obstacle_; }

 private:
  [[nodiscard]] std::optional<StartingPair> tryPair(double least_rad, double sure_rad);
  void forgetUnconnected();

  const AnyCamera& camera_;
  ImageSize size_;
  const SightScale& scale_;
  std::uint64_t seed_;
  std::deque<WaitingFrame> waiting_;
  std::deque<WaitingFrame> earlier_;
  double wanted_rad_;
  StartObstacle obstacle_ = StartObstacle::kFewPoints;
};

}  // namespace alidade
