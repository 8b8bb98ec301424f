// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// Seed of the random samples.
inline constexpr std::uint64_t kPathSeed = 1;

/// Angular resolution of a camera, and thresholds for its images.
struct SightScale {
  double threshold_px = 2;
  double px_per_rad = 500;  ///< in the middle of the image
  double least_rad = 0.01;  ///< between the rays to a point, from which its distance is known
  double key_rad = 0.04;    ///< between the rays of two key frames

  SightScale(const AnyCamera& camera, ImageSize size);
};

/// The pose of a frame from points of the map.
struct PlacedFrame {
  SE3 camera_from_world;
  std::size_t num_points = 0;    ///< that agree, at a known distance
  std::size_t num_distant = 0;   ///< that agree, at an unknown distance
  double squared_error_px2 = 0;  ///< sum over both
};

/// The last few key frames of a path and their points.
class LocalMap {
 public:
  LocalMap(const AnyCamera& camera, const SightScale& scale) : camera_(camera), scale_(scale) {}

  /// A pose from recently seen points.
  /// @param tracks  of the frame
  /// @param guess   camera_from_world
  [[nodiscard]] std::optional<PlacedFrame> place(std::span<const TrackPixel> tracks, const SE3& guess,
                                                 std::size_t frame);
  /// A pose from any points of the map, after tracking was lost.
  [[nodiscard]] std::optional<PlacedFrame> relocate(std::span<const TrackPixel> tracks, std::size_t frame);

  /// Sets the position of a point, before key frames that show it are added.
  void setPoint(std::uint32_t track, const Eigen::Vector4d& at);

  /// Adds a key frame; call settle() after adding one or more.
  /// @param frame  higher than those before
  void addKeyFrame(std::size_t frame, std::span<const TrackPixel> tracks, const SE3& camera_from_world);
  /// Positions the points and adjusts the window.
  void settle();

  /// True if a frame should become a key frame.
  [[nodiscard]] bool needsKeyFrame(std::span<const TrackPixel> tracks, const PlacedFrame& placed) const;

  [[nodiscard]] const SE3& lastPose() const { return window_.back().camera_from_world; }
  /// The last key frame's tracks.
  [[nodiscard]] const std::vector<TrackPixel>& lastTracks() const { return window_.back().tracks; }
  /// Median distance of the points of the last key frame.
  [[nodiscard]] double depth() const { return depth_; }
  /// The position of a recently seen point, if its distance is known.
  [[nodiscard]] std::optional<Eigen::Vector3d> placeOf(std::uint32_t track) const;
  /// Poses of all key frames by frame.
  [[nodiscard]] const std::map<std::size_t, SE3>& poses() const { return poses_; }
  /// Positions of the points that three or more key frames saw, at a known distance.
  [[nodiscard]] std::vector<Eigen::Vector3d> points() const;

 private:
  struct Point {
    Eigen::Vector4d at = Eigen::Vector4d::Zero();
    bool is_placed = false;
    bool is_far = false;            // rays to it are parallel over the whole window
    int num_misses = 0;             // consecutive frames that contradict the position
    int num_failures = 0;           // positions that were given up recently
    std::size_t ignored_until = 0;  // frame
    std::size_t num_keys = 0;
    std::size_t last_frame = 0;          // last frame that agreed
    Eigen::Vector3d anchor{0, 0, 0};     // first camera that saw it, in the world
    Eigen::Vector3d direction{0, 0, 0};  // from there, of length 1; zero before the first key frame

    [[nodiscard]] bool isAtKnownDistance() const { return is_placed && !is_far && at.w() > 0; }
    [[nodiscard]] Eigen::Vector3d place() const { return at.head<3>() / at.w(); }
  };
  struct KeyFrame {
    std::size_t frame = 0;
    SE3 camera_from_world;
    std::vector<TrackPixel> tracks;
    std::vector<std::optional<Eigen::Vector3d>> rays;
    std::vector<char> is_used;  // the sighting agrees with its point
    std::size_t num_points = 0;
  };
  // Pairs of a key frame in the window and an index among its tracks.
  using Sightings = std::vector<std::pair<std::size_t, std::size_t>>;

  [[nodiscard]] const Point* find(std::uint32_t track) const;
  [[nodiscard]] bool isOfUse(const Point& point) const;
  [[nodiscard]] std::map<std::uint32_t, Sightings> sightingsInWindow() const;
  [[nodiscard]] double widestAngle(const Sightings& sightings) const;
  void giveUp(Point& point);
  void triangulate(std::uint32_t track, const Sightings& sightings);
  void adjust();
  void measureDepth();

  const AnyCamera& camera_;
  const SightScale& scale_;
  std::map<std::uint32_t, Point> points_;
  std::deque<KeyFrame> window_;
  std::map<std::size_t, SE3> poses_;
  std::size_t num_keys_ = 0;
  std::size_t now_ = 0;  // newest frame
  double depth_ = 1;     // median distance of the points of the last key frame
};

}  // namespace alidade
