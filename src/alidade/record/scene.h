// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/hand_eye_record.h"
#include "alidade/record/robot_poses.h"
#include "alidade/target/board.h"

namespace alidade {

/// Checks an option of a simulation, which may come from a scene file.
/// @throws Error (kInput) naming the option when `value` is not in [low, high], or NaN.
namespace detail {
void checkOption(const char* name, double value, double low, double high);
}

/// Distribution of the views that randomViews() draws.
struct RandomViewOptions {
  static constexpr double kSmallestFill = 0.01;  ///< smallest allowed `min_fill`

  double max_tilt_deg = 45;  ///< largest angle between the board's normal and the ray to its centre
  double max_roll_deg = 30;  ///< largest turn of the board about its normal, either way; 180 = any
  /// The larger of the shares of the image's width and height that the squares span: min_fill to max_fill.
  double min_fill = 0.35;
  double max_fill = 0.8;
  double margin_px = 4;    ///< all squares stay this far inside the image's border
  int max_attempts = 100;  ///< placements tried for each fill before it is reduced

  /// @throws Error (kInput) naming the first option that is out of its range.
  void validate() const;
};

/// Appearance of a rendered image. Grey levels are those of the 8-bit image, 0 to 255, proportional to light.
struct RenderOptions {
  double blur_px = 0.8;  ///< standard deviation of the lens' Gaussian blur, besides the pixel's own square
  double dark_level = 30;
  double bright_level = 220;
  double background_level = 110;
  double border_square = 1;  ///< width of the outermost squares as a share of a square, in [0.01, 1]
  double falloff = 0;        ///< share of the light lost, linearly, from the left border to the right one
  double vignetting_exponent = 0;  ///< light falls by cos^n of the angle to the optical axis; 4 is natural
  double read_noise = 1.5;         ///< standard deviation of the noise without light, grey levels
  /// Electrons at level 255, which set the shot noise: its variance in electrons equals their number. 0: no
  /// shot noise.
  double full_well_electrons = 10000;
  std::uint64_t seed = 1;  ///< of the noise; use a different one for each image
  /// Sample positions over which a pixel's light is averaged, see makePointSpread(). At edges between the
  /// default levels 987 err by 0.3 grey levels (RMS; 377 by 0.6).
  int samples = 987;
  int num_jobs = 0;  ///< threads; 0: one per processor. The image does not depend on it.

  /// @throws Error (kInput) naming the first option that is out of its range.
  void validate() const;
};

/// A robot that moves the camera, or the board before it, see simulateRobot().
struct SceneRobot {
  CameraOn camera_on = CameraOn::kHand;
  int num_poses = 15;  ///< at most 1000
  RobotNoise noise = {.rotation_rad = 5e-4, .translation_m = 2e-4};
  std::optional<RobotMistake> mistake = {};
};

/// A simulation: a camera, a board, and the poses of the board, given or drawn at random.
struct Scene {
  AnyCamera camera;
  ImageSize image_size;
  Board board;
  std::vector<SE3> camera_from_board = {};  ///< given poses; empty = draw `num_random_views`
  int num_random_views = 0;
  std::optional<SceneRobot> robot = {};  ///< in place of the poses
  std::uint64_t seed = 1;                ///< of poses and corner noise
  RandomViewOptions random_views = {};
  RenderOptions render = {};
  double corner_noise_px = 0;  ///< added to the corners file; 0 = exact
  /// Skipped or assumed parts of the camera's file, one sentence each.
  std::vector<std::string> camera_remarks = {};
  std::vector<std::string> files = {};  ///< named in the scene's file: the camera's, the board's
};

}  // namespace alidade
