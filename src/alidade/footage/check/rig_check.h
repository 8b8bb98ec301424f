// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/camera/any_rig.h"
#include "alidade/core/image.h"
#include "alidade/footage/check/explain.h"
#include "alidade/footage/check/pair_fit.h"

namespace alidade {

/// The change of a rig that fits the matches best. Its effects are distances from the epipolar curve that the
/// change gives to points 10 baselines away, in the second image: rows of rectified images differ by so much.
/// Its gain is its share of the squared errors, less 6 for each unknown and its prior's part.
struct RigChange : ChangeFit {
  PairSide side = PairSide::kBoth;
  PosedPair pair;             ///< after it
  double angle_std = 0;       ///< of the length of a rotation's or position's amounts, radians
  double rms_px = 0;          ///< Sampson error after it
  double depth_blind_px = 0;  ///< as blind_px, in any direction: along the curve it is an error of depth
};

/// The test of two cameras of a rig: kNoParallax means that all points are far away. Its
/// `blind_px` is that of rows, of rotation, baseline, focal length and distortion; its parallax the median
/// distance from where points at infinity would be.
struct RigPairCheck : FootageOutcome {
  std::size_t first = 0;  ///< index of the camera in the rig
  std::size_t second = 0;
  std::vector<RigChange> changes = {};  ///< those that were tried
  /// Most points lie behind the cameras: images exchanged, or turned or shifted along rows.
  bool is_behind = false;
  int num_instants = 0;      ///< with 12 matches or more that were used
  int num_matches = 0;       ///< with rays
  int num_used = 0;          ///< without outliers
  double outlier_share = 0;  ///< of the matches
  double rms_px = 0;         ///< Sampson error of the used matches, as stated
};

/// The test of a whole rig.
struct RigCheck {
  FootageVerdict verdict = FootageVerdict::kCannotTell;
  std::vector<RigPairCheck> pairs;
};

/// Rows that differ by this are not known to be wrong: five times as much fails.
inline constexpr double kRigFootageTolerancePx = 0.2;

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
                                         const FootageCheckOptions& options = {
                                             .tolerance_px = kRigFootageTolerancePx});

/// "right turned by 0.31 deg +- 0.01 deg against left".
[[nodiscard]] std::string describe(const RigChange& change, std::string_view first, std::string_view second);

}  // namespace alidade
