// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/footage_scene.h"
#include "alidade/simulate/footage_frame.h"
#include "alidade/simulate/footage_motion.h"
#include "alidade/simulate/scene_bodies.h"

namespace alidade {

/// A point on a surface of simulated footage.
struct ScenePoint {
  int body = 0;             ///< index of the body it is fixed to; bodies are numbered from 0
  int face = 0;             ///< of the body, 0 to 5
  Eigen::Vector3d in_body;  ///< in the body frame, metres
  bool is_moving = false;   ///< on an object that moves on its own
};

/// A point and its exact pixels in frames that follow one another.
struct TrueTrack {
  int id = 0;  ///< index in the list of tracks
  ScenePoint point;
  int first_frame = 0;
  std::vector<Eigen::Vector2d> pixels;  ///< in first_frame, first_frame + 1, ...
};

/// Options of trackPoints().
struct TrackOptions {
  /// Cells of a grid over the image. In each frame, an empty cell gets a point at a random place.
  int columns = 16;
  int rows = 12;
  bool on_moving_objects = true;  ///< false: only points that do not move
};

/// Renders footage and gives its ground truth. Frames are numbered from 0; frame i is taken at i /
/// frame_rate_hz seconds. Poses are camera_from_world.
///
/// Rolling shutter: row v of frame i is taken at (i + rolling_shutter * (v - (height - 1) / 2) / height) /
/// frame_rate_hz seconds.
///
/// Stabilisation imitates telephones: pixels p of the camera are moved to H p, where H = K R K^-1 with the
/// focal lengths at the image centre and the principal point in K. R takes the true orientation at the time
/// of the frame to the smoothed one. H would be exact for a lens without distortion. For other lenses, and
/// with a rolling shutter, the pictures no longer match the camera model exactly. The sensor is larger than
/// the picture, so that the picture has no empty margins where the lens has rays.
class FootageSimulator {
 public:
  /// Builds the surroundings and finds the speed for the required flow, which takes some milliseconds.
  /// @throws Error (kInput) for values out of range, if no speed gives the required flow, and if the moving
  /// objects cannot cover `moving_share`
  explicit FootageSimulator(FootageScene scene);

  /// The scene, with the default flow filled in.
  [[nodiscard]] const FootageScene& scene() const { return scene_; }
  [[nodiscard]] int numFrames() const { return scene_.num_frames; }
  [[nodiscard]] double timeOf(int frame) const { return frame / scene_.frame_rate_hz; }

  /// The camera of a frame: the scene's, with fx and fy multiplied by the zoom.
  [[nodiscard]] const AnyCamera& cameraOf(int frame) const {
    return cameras_.size() == 1 ? cameras_.front() : cameras_.at(static_cast<std::size_t>(frame));
  }
  /// The true pose of the camera at any time, camera_from_world.
  [[nodiscard]] SE3 poseAt(double time_s) const;
  /// The pose of a picture, camera_from_world: the true pose at the time of the frame or, with stabilisation,
  /// that of the camera with the smoothed orientation.
  [[nodiscard]] SE3 poseOf(int frame) const;

  /// The same bytes for the same scene and frame, regardless of the number of threads. Pixels without a ray
  /// get no light.
  /// @throws Cancelled once `cancel` is set.
  [[nodiscard]] GrayImage renderFrame(int frame, const CancelFlag* cancel = nullptr) const;

  /// The point that is seen at a pixel; nothing if the pixel has no ray, or looks past the plane.
  [[nodiscard]] std::optional<ScenePoint> pointAt(int frame, const Eigen::Vector2d& pixel) const;
  /// The exact pixel of a point; nothing if it is hidden, outside the image or without projection. With a
  /// rolling shutter, it is the one at the time of its own row.
  [[nodiscard]] std::optional<Eigen::Vector2d> pixelOf(const ScenePoint& point, int frame) const;
  /// Position of a point at a time, in the world frame, metres.
  [[nodiscard]] Eigen::Vector3d positionOf(const ScenePoint& point, double time_s) const;

  /// Exact tracks over the whole footage, covering all parts of the image in each frame, without rendering. A
  /// track ends when its point is hidden or leaves the image. The same scene gives the same tracks.
  [[nodiscard]] std::vector<TrueTrack> trackPoints(const TrackOptions& options = {}) const;

 private:
  void findSpeed();
  void setSpeed(double speed);
  void addMovingBodies();
  [[nodiscard]] double meanFlow() const;
  [[nodiscard]] double movingShare() const;
  [[nodiscard]] FootageFrame frame(int index) const {
    return {scene_, cameraOf(index), motion_, bodies_, index};
  }

  FootageScene scene_;
  std::vector<AnyCamera> cameras_;  // of each frame; one if all are the same
  double focal_px_;                 // pixels per radian at the image centre, without zoom
  FootageMotion motion_;
  std::vector<SceneBody> bodies_;
};

}  // namespace alidade
