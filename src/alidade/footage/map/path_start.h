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

/// Why no segment could be started.
enum class StartObstacle : std::uint8_t {
  kNone,
  kFewPoints,  ///< the frames share too few points
  kStill,      ///< nothing moves
  kRotation,   ///< points move as if the camera turned in place
  kNoMotion,   ///< points move, but not as one rigid scene
};
/// "none", "few_points", "still", "rotation", "no_motion".
[[nodiscard]] std::string_view obstacleId(StartObstacle obstacle);

/// A frame that waits for its pose.
struct WaitingFrame {
  std::size_t index = 0;  ///< into Path::frames
  std::vector<TrackPixel> tracks;
};

/// Two of the waiting frames between which the camera moved.
struct StartingPair {
  std::size_t a = 0;  ///< indices into PathStart::waiting()
  std::size_t b = 0;
  TwoView motion;
  std::vector<std::uint32_t> tracks;  ///< of the matches of the motion
};

/// Collects frames until two of them show the camera's motion.
class PathStart {
 public:
  PathStart(const AnyCamera& camera, ImageSize size, const SightScale& scale, std::uint64_t seed);

  /// Takes a frame. @returns a pair once there is one
  [[nodiscard]] std::optional<StartingPair> add(std::size_t index, std::span<const TrackPixel> tracks);
  /// With a smaller parallax than add() asks for: at the end of the footage, which brings no better one.
  [[nodiscard]] std::optional<StartingPair> lastChance();
  /// Whether a frame shares too little with the one before for anything to go on.
  [[nodiscard]] bool isCutOff(std::span<const TrackPixel> tracks) const;

  /// The pair did not lead to poses of the frames between: waits for a larger parallax.
  void reject();
  [[nodiscard]] const std::deque<WaitingFrame>& waiting() const { return waiting_; }
  /// Those before the waiting ones, with which they share too little.
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
