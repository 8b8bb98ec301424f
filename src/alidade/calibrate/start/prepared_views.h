// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// Fewest views from which a calibration is attempted. Two would determine four parameters but leave nothing
/// to detect a mistake with.
inline constexpr int kMinViews = 3;

/// Fewest corners for a view to be used.
inline constexpr std::size_t kMinCornersPerView = 6;

/// The input of a calibration, checked and in order.
struct PreparedViews {
  std::vector<Board> boards;              ///< View::board is an index into these
  std::vector<View> views = {};           ///< in order of names and boards, corners in order of their ids;
                                          ///< FitView::source is an index into these
  std::vector<std::size_t> sources = {};  ///< of each view, its index among the given ones
  Dropped dropped = {};                   ///< views with too few corners and repeated ones
};

/// Checks and sorts the input, and leaves out views with too few corners and copies of others.
/// @throws Error (kInput), see calibrate()
[[nodiscard]] PreparedViews prepareViews(std::span<const Board> boards, std::vector<View> views);

/// The corners of each view, see observationsOf().
[[nodiscard]] std::vector<std::vector<Observation>> cornersOf(const PreparedViews& given);

/// The views that a fit does not use, in their order.
[[nodiscard]] std::vector<std::size_t> viewsLeftOut(const PreparedViews& given, const Fit& fit);

/// @throws Error (kInput) with the reasons of the views left out if the fit has fewer than kMinViews
void requireViews(const PreparedViews& given, const Fit& fit);

/// Merges all views in which a board stands at the same place: duplicates of an image, re-encoded or
/// retouched, or a series from a tripod. The effects of lens, board shape and blur are identical in all of
/// them; only corner noise may differ. Counted separately, they would suggest too much certainty and outweigh
/// the rest.
///
/// The merged view keeps the name of the first one (in order of names). Each corner is at the median, per
/// axis, of its positions in the group; its sigma stays that of one view.
///
/// Two views of one board repeat each other if they have most corners in common, the affine part of the
/// corners' displacements, which a change of pose causes, is within kSamePlacePx, and the remainder is no
/// larger than noise.
/// @param given  with views in order of their names; those that repeat others go to `dropped`
void mergeRepeatedViews(PreparedViews& given);

/// Largest displacement of corners that still counts as the same pose, RMS over the corners, px.
inline constexpr double kSamePlacePx = 0.25;

}  // namespace alidade
