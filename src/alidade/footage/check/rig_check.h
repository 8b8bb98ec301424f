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

/// The change of a rig that fits the matches best. Effects are distances in the second image from the changed
/// epipolar curve, for points 10 baselines away: rows of rectified images differ by this much. Gain is the
/// share of the squared errors, less 6 for each unknown and the prior's part.
struct RigChange : ChangeFit {
  PairSide side = PairSide::kBoth;
  PosedPair pair;             ///< the changed pair
  double angle_std = 0;       ///< of the norm of a rotation's or position's amounts, radians
  double rms_px = 0;          ///< Sampson error after the change
  double depth_blind_px = 0;  ///< as blind_px, in any direction; along the curve it is a depth error
};

/// The test of two cameras of a rig; kNoParallax means that all points are far away. `blind_px` is that of
/// rows: for rotation, baseline, focal length and distortion. The parallax is the median distance from the
/// images of points at infinity.
struct RigPairCheck : FootageOutcome {
  std::size_t first = 0;  ///< index of the camera in the rig
  std::size_t second = 0;
  std::vector<RigChange> changes = {};  ///< changes that were tried
  /// Most points lie behind the cameras: images exchanged, turned, or shifted along rows.
  bool is_behind = false;
  int num_instants = 0;      ///< with at least 12 used matches
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

/// Row differences up to this are acceptable; five times as much fails.
inline constexpr double kRigFootageTolerancePx = 0.2;

/// Matched key points of two cameras.
struct RigPairMatches {
  std::size_t first = 0;  ///< index of the camera in the rig
  std::size_t second = 0;
  std::vector<std::vector<PixelMatch>> instants;  ///< one list per pair of synchronous images
};

/// Key points (KeyPointMatcher) common to two images.
[[nodiscard]] std::vector<PixelMatch> matchImages(const GrayImage& first, const GrayImage& second,
                                                  std::size_t num_points);

/// Tests the lenses and relative poses of a rig on matched points, pair by pair. The Sampson error of all
/// matches of a pair, in pixels of both images (Sampson 1982), is minimised over one group of unknowns at a
/// time, with everything else as stated. A change counts if it is far beyond chance (by the scatter of
/// matches or of instants, whichever is larger) and if its effect exceeds five times the tolerance, and with
/// certainty half of that. All unknowns at once count only if the effect is twice as large, because they also
/// absorb errors of the lens models. Matches that a changed rig explains, but not the stated one, are
/// included. If a separate pose for each instant explains clearly more than any change, there is no verdict.
/// A pair is called consistent only if at least three instants have matches, and a rig if consistent pairs
/// connect all its cameras.
/// @param matches  of each pair of cameras that have synchronous images
/// @throws Cancelled
[[nodiscard]] RigCheck checkRigOnFootage(const AnyRig& rig, std::span<const RigPairMatches> matches,
                                         const FootageCheckOptions& options = {
                                             .tolerance_px = kRigFootageTolerancePx});

/// "right turned by 0.31 deg +- 0.01 deg against left".
[[nodiscard]] std::string describe(const RigChange& change, std::string_view first, std::string_view second);

}  // namespace alidade
