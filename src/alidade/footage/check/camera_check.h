// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/footage/check/camera_windows.h"
#include "alidade/footage/follow/tracks.h"

namespace alidade {

/// What footage says of a camera.
enum class FootageVerdict : std::uint8_t {
  kConsistent,
  kInconsistent,
  kCannotTell,
};
/// "consistent", "inconsistent", "cannot_tell".
[[nodiscard]] std::string_view verdictId(FootageVerdict verdict);

/// Why footage cannot tell.
enum class FootageGap : std::uint8_t {
  kNone,
  kFewPoints,    ///< too few points could be followed
  kNoMotion,     ///< all frames show the same
  kNoParallax,   ///< the camera turned in place, or all is far away
  kMovingScene,  ///< too few points agree with one motion of the camera
  kFewFrames,    ///< fewer than five frames could be reconstructed together
  kUnsolved,     ///< a change that may explain the footage could not be solved for
  kWeak,         ///< the motion leaves the camera's parameters undetermined
};
/// "too_few_points", "no_motion", "no_parallax", "moving_scene", "too_few_frames",
/// "unsolved", "undetermined"; empty for kNone.
[[nodiscard]] std::string_view gapId(FootageGap gap);

/// One way in which a camera file may be wrong.
enum class CameraChangeKind : std::uint8_t {
  kFocalLength,
  kAspect,  ///< fx alone: the image was stretched
  kPrincipalPoint,
  kDistortion,   ///< all of it by one factor
  kFirstRadial,  ///< the first coefficient of the lens alone
  kSeveral,      ///< all parameters
};
/// "focal_length", "aspect", "principal_point", "distortion", "radial", "several".
[[nodiscard]] std::string_view changeId(CameraChangeKind kind);

/// The change of this kind that fits the footage best.
struct CameraChange {
  CameraChangeKind kind = CameraChangeKind::kSeveral;
  AnyCamera camera;             ///< after it
  std::vector<double> amounts;  ///< see describe(): focal length and aspect as a share, pixels, and so on
  std::vector<double> std;      ///< of each
  double cost_drop = 0;         ///< share of the sum of squared errors that the change takes away
  double score = 0;             ///< half the drop in units of its variance, less 6 for each unknown
  /// 95th percentile of the displacement of pixels where points were seen, by the change, in one camera
  /// frame; and what is left of it 1.645 standard deviations nearer to no change.
  double effect_px = 0;
  double sure_px = 0;
  /// The same percentile of 1.96 standard deviations: a change of this kind that would go unnoticed.
  double blind_px = 0;
};

/// The mean error in a part of the image, of points found without the pixel in question.
struct FootageCell {
  int num_pixels = 0;
  double rms_px = 0;
  Eigen::Vector2d mean_px{0, 0};  ///< projected minus observed
};

struct FootageCheck {
  FootageVerdict verdict = FootageVerdict::kCannotTell;
  FootageGap gap = FootageGap::kNone;
  std::vector<CameraChange> changes;       ///< those that were tried
  std::optional<std::size_t> explanation;  ///< the change that explains the footage best, if one does
  double tolerance_px = 1;
  /// The largest change of focal length or distortion that would go unnoticed.
  double blind_px = 0;
  /// Kinds of which a change of ten times the tolerance would go unnoticed. Where the principal point is the
  /// only one, the camera may still be consistent: rotations compensate for most of its displacement.
  std::vector<CameraChangeKind> undetermined;
  int num_frames = 0;  ///< in windows
  int num_windows = 0;
  int num_points = 0;
  int num_pixels = 0;
  double parallax_px = 0;
  double noise_px = 0;
  double holdout_rms_px = 0;  ///< errors of pixels without which their points were found
  static constexpr int kColumns = 8;
  static constexpr int kRows = 6;
  std::vector<FootageCell> cells;  ///< row by row
  double readout = 0;              ///< of a rolling shutter, in frames; 0 for photographs
  bool is_video = false;
};

struct FootageCheckOptions {
  double tolerance_px = 1;
  int num_jobs = 0;
  const CancelFlag* cancel = nullptr;
};

/// Tests a camera on footage of a rigid scene. Poses and points are found with the camera as it is, and then
/// again with one of its properties changed at a time. Where all parameters together find a camera that is
/// far from it and explains more pixels, these pixels are used. The change that takes away most of the
/// squared errors is the explanation, if it is significant (1 in 1000) and if a change of ten times the
/// tolerance would not go unnoticed. The camera is inconsistent if the explanation displaces pixels by more
/// than five times the tolerance, surely by more than half of that. All parameters at once need a quarter
/// more than that change; if it alone does not make the camera wrong, half of the squared errors: small
/// errors of tracks that all images share would otherwise be taken for a lens. A camera is called consistent
/// only if five frames or more were reconstructed together.
/// @param tracks  of keyframes
[[nodiscard]] FootageCheck checkOnFootage(const AnyCamera& camera, const FootageTracks& tracks,
                                          const FootageCheckOptions& options = {});

/// "focal length +3.1 % +- 0.2 %".
[[nodiscard]] std::string describe(const CameraChange& change);

}  // namespace alidade
