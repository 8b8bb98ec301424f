// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/camera/any_rig.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/footage/check/camera_check.h"
#include "alidade/footage/geometry/two_view.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// One way in which the file of a rig may be wrong for two of its cameras.
enum class RigChangeKind : std::uint8_t {
  kRotation,        ///< one camera turned about its centre: rotation vector in its frame, radians
  kFocalLength,     ///< as a share
  kDistortion,      ///< all of it by one factor, less 1
  kFirstRadial,     ///< the first coefficient of a lens without distortion
  kPosition,        ///< direction of the baseline, two angles in radians; its length cannot be seen
  kPrincipalPoint,  ///< px
  kPose,            ///< rotation of the second camera and direction of the baseline
  kSeveral,         ///< pose, focal lengths, distortion and principal points of both
};
/// "rotation", "focal_length", "distortion", "radial", "position", "principal_point", "pose", "several".
[[nodiscard]] std::string_view rigChangeId(RigChangeKind kind);

/// The camera of a pair that changes.
enum class PairSide : std::uint8_t { kFirst, kSecond, kBoth };

/// Two cameras and where the second one is. The translation has length 1.
struct PosedPair {
  AnyCamera first;
  AnyCamera second;
  SE3 second_from_first;
};

/// The change of this kind that fits the matches best.
struct RigChange {
  RigChangeKind kind = RigChangeKind::kSeveral;
  PairSide side = PairSide::kBoth;
  PosedPair pair;                    ///< after it
  std::vector<double> amounts = {};  ///< see RigChangeKind
  std::vector<double> std = {};      ///< of each
  double angle_std = 0;              ///< of the length of a rotation's or position's amounts, radians
  double rms_px = 0;                 ///< Sampson error after it
  double cost_drop = 0;              ///< share of the sum of squared errors that the change removes
  double prior_cost = 0;             ///< half the squares of the amounts in units of what is usual
  double gain = 0;                   ///< the same share less 6 for each unknown and its prior's part
  double score = 0;                  ///< half the drop in units of its variance, less the same
  /// 95th percentile of the distance from the epipolar curve that the change gives to points 10 baselines
  /// away, in the second image, where matches were seen: rows of rectified images differ by so much. Then
  /// what is left of it 1.645 standard deviations nearer to no change.
  double effect_px = 0;
  double sure_px = 0;
  /// The same percentile of 1.96 standard deviations: a change of this kind that would go unnoticed.
  double blind_px = 0;
  /// The same of the displacement of these points in any direction: along the epipolar curve it is an error
  /// of depth.
  double depth_blind_px = 0;
};

/// What the images of two cameras say of a rig.
struct RigPairCheck {
  std::size_t first = 0;  ///< index of the camera in the rig
  std::size_t second = 0;
  FootageVerdict verdict = FootageVerdict::kCannotTell;
  FootageGap gap = FootageGap::kNone;  ///< kNoParallax: all points are far away
  std::vector<RigChange> changes;      ///< those that were tried
  std::optional<std::size_t> explanation;
  std::vector<std::size_t> alternatives;  ///< other changes that explain nine tenths as much
  bool is_behind =
      false;  ///< most points lie behind the cameras: images exchanged, or turned or shifted along rows
  double tolerance_px = 0;
  double blind_px = 0;  ///< of rows: the largest error of rotation, baseline, focal length or distortion that
                        ///< would go unnoticed
  int num_instants = 0;      ///< with 12 matches or more that were used
  int num_matches = 0;       ///< with rays
  int num_used = 0;          ///< without outliers
  double outlier_share = 0;  ///< of the matches
  double noise_px = 0;       ///< of a coordinate
  double rms_px = 0;         ///< Sampson error of the used matches, as stated
  double parallax_px = 0;    ///< median distance from where points at infinity would be
};

/// What the images say of a rig.
struct RigCheck {
  FootageVerdict verdict = FootageVerdict::kCannotTell;
  std::vector<RigPairCheck> pairs;
};

/// Rows that differ by this are not known to be wrong: five times as much fails.
inline constexpr double kRigFootageTolerancePx = 0.2;

struct RigCheckOptions {
  double tolerance_px = kRigFootageTolerancePx;
  int num_jobs = 0;
  const CancelFlag* cancel = nullptr;
};

/// Matched key points of two cameras.
struct RigPairMatches {
  std::size_t first = 0;  ///< index of the camera in the rig
  std::size_t second = 0;
  std::vector<std::vector<PixelMatch>> instants;  ///< of each pair of synchronous images
};

/// Key points (KeyPointMatcher) that two images show.
[[nodiscard]] std::vector<PixelMatch> matchImages(const GrayImage& first, const GrayImage& second,
                                                  std::size_t num_points);

/// Tests the lenses and relative poses of a rig on matched points, pair by pair. The Sampson error of all
/// matches of a pair, in pixels of both images (Sampson 1982), is minimised over one group of unknowns at a
/// time: all else stays as stated. A change counts if it is far beyond chance (the scatter of matches
/// and of instants counts, whichever is larger), if its effect exceeds five times the tolerance, and surely
/// half of that. All unknowns at once count only if the effect is twice as large: they also absorb what lens
/// models leave. Matches that the stated rig does not explain, but a changed one does, are judged too.
/// A pair is called consistent only if three instants or more have matches, and a rig if consistent pairs
/// connect all its cameras.
/// @param matches  of each pair of cameras that have synchronous images
/// @throws Cancelled
[[nodiscard]] RigCheck checkRigOnFootage(const AnyRig& rig, std::span<const RigPairMatches> matches,
                                         const RigCheckOptions& options = {});

/// "right turned by 0.31 deg +- 0.01 deg against left".
[[nodiscard]] std::string describe(const RigChange& change, std::string_view first, std::string_view second);

}  // namespace alidade
