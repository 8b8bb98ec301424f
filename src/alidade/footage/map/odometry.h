// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/footage/map/local_map.h"
#include "alidade/footage/map/path_start.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// Pose of the camera at one frame.
struct PathFrame {
  std::size_t number = 0;              ///< of the frame, as given
  std::optional<std::size_t> segment;  ///< index into Path::segments; nothing for a frame without a pose
  SE3 camera_from_world;               ///< in the world of the segment
  bool is_key = false;                 ///< its pose was adjusted together with the points
  std::size_t num_points = 0;          ///< that agree with the pose
};

/// Frames connected by points. The world is the camera of its first frame at the start, and the scale is
/// arbitrary: worlds and scales of two segments are unrelated.
struct PathSegment {
  std::size_t begin = 0;  ///< first frame, an index into Path::frames
  std::size_t end = 0;    ///< one past the last one
  std::size_t num_keys = 0;
  double length = 0;  ///< of the path
  /// Frames at which the scale was carried over by an assumption: all points with a known distance were out
  /// of sight, for instance after a turn in place, and the new ones were assumed to be as far away as the old
  /// ones.
  std::vector<std::size_t> scale_breaks;
  std::vector<Eigen::Vector3d> points;  ///< in the world, those at a known distance
};

struct Path {
  std::vector<PathFrame> frames;  ///< all that were given
  std::vector<PathSegment> segments;
  StartObstacle obstacle = StartObstacle::kNone;  ///< the last one encountered
  double rms_px = 0;                              ///< of the agreeing points, over all frames with a pose

  [[nodiscard]] std::size_t numPosed() const;
};

/// Finds the path of a camera from points tracked from frame to frame. It starts with two views between which
/// points move by a few percent of the width in addition to any rotation. Every further frame is placed by
/// points of known position. Every few frames, a key frame determines the positions of new points, and the
/// last few key frames are adjusted together with their points, with the oldest two held. There is no map
/// beyond that: errors accumulate along the path, and a place that is seen again is not recognised.
class Odometry {
 public:
  Odometry(const AnyCamera& camera, ImageSize size);
  Odometry(const Odometry&) = delete;
  Odometry& operator=(const Odometry&) = delete;

  /// @param number  of the frame, higher than before
  /// @param tracks  in ascending order of track
  void add(std::size_t number, std::span<const TrackPixel> tracks);

  /// The path, including frames at the end that show little motion. Nothing may be added afterwards.
  [[nodiscard]] Path finish();

 private:
  // The motion of two views, in the world of the segment that it belongs to.
  struct Joint {
    SE3 camera_from_world;  // of the first view
    double scale = 1;
    bool is_joined = false;         // to the previous segment
    bool is_scale_assumed = false;  // assumes points at the distance of earlier ones
  };

  bool follow(std::size_t index, std::span<const TrackPixel> tracks);
  void makeKeyFrame(std::size_t index, std::span<const TrackPixel> tracks);
  void setKey(std::size_t index);
  void record(std::size_t index, const PlacedFrame& placed);
  [[nodiscard]] Joint jointOf(const TwoView& motion, const std::vector<std::uint32_t>& tracks) const;
  void begin(const TwoView& motion);
  void placeEarlier(std::size_t first);
  void fixPoses();
  [[nodiscard]] double lengthOf(std::size_t segment) const;

  AnyCamera camera_;
  ImageSize size_;
  SightScale scale_;
  std::optional<PathStart> start_;
  std::optional<LocalMap> map_;
  bool is_tracking_ = false;
  bool is_scale_lost_ = false;
  Path path_;
  // For each frame of the last segment: a key frame, whose pose may still change, and the pose relative to
  // it.
  std::map<std::size_t, std::pair<std::size_t, SE3>> relative_;
  std::size_t key_ = 0;                  // last key frame
  SE3 last_;                             // camera_from_world of the last frame
  SE3 step_;                             // frame_from_frame_before
  std::vector<TrackPixel> last_tracks_;  // of the last frame that was tracked
  double squared_error_px2_ = 0;
  std::size_t num_errors_ = 0;
};

}  // namespace alidade
