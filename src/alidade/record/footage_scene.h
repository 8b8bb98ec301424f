// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"

namespace alidade {

/// The static surroundings that the camera sees.
enum class FootageSurroundings {
  kRoom,   ///< a closed room with boxes and pillars at several depths: parallax everywhere
  kPlane,  ///< one infinite plane: ahead of the camera, or the ground for straight paths
  kFar,    ///< everything is so far away that translations have no effect
};

/// How the camera moves.
enum class FootagePath {
  kWalk,      ///< translates and looks around
  kRotation,  ///< rotates about its centre of projection: no parallax
  kStatic,    ///< does not move
  kStraight,  ///< drives along its optical axis at a constant speed
};

/// Differences between footage and sharp pictures of a rigid scene by a camera with a global shutter.
struct FootageEffects {
  double shake_px = 0;     ///< RMS displacement at the image centre by camera shake, per axis of rotation
  int moving_objects = 0;  ///< textured boxes that move on their own
  /// Share of the image that they cover on average; 0 = unspecified.
  double moving_share = 0;
  /// Time from the first row to the last one, relative to the time between frames; 0 = global shutter. The
  /// middle of the image is taken at the time of the frame.
  double rolling_shutter = 0;
  /// Standard deviation, in frames, of the Gaussian over time by which stabilisation smooths the orientation;
  /// 0 = no stabilisation.
  double stabilisation_frames = 0;
  double zoom = 1;          ///< focal length of the last frame relative to the first, linear in between
  double blur_px = 0.7;     ///< standard deviation of the lens' Gaussian blur, besides the pixel's own square
  double read_noise = 1.5;  ///< standard deviation of the noise, grey levels
};

/// Simulated footage: ordinary pictures of textured surfaces by one camera that moves.
struct FootageScene {
  AnyCamera camera;
  ImageSize image_size;
  FootageSurroundings surroundings = FootageSurroundings::kRoom;
  FootagePath path = FootagePath::kWalk;
  int num_frames = 60;
  double frame_rate_hz = 30;
  /// Mean displacement of static points per frame, over image and footage; sets the speed of the path. It
  /// does not include `shake_px`. 0 = an eightieth of the image's width.
  double flow_px = 0;
  FootageEffects effects = {};
  std::uint64_t seed = 1;  ///< of surfaces, path, objects and noise
  int num_jobs = 0;        ///< threads; 0: one per processor. The pictures do not depend on it.
  /// Skipped or assumed parts of the camera's file, one sentence each.
  std::vector<std::string> camera_remarks = {};
  std::vector<std::string> files = {};  ///< named in the scene's file: the camera's

  /// @throws Error (kInput) naming the first value that is out of its range.
  void validate() const;
};

}  // namespace alidade
