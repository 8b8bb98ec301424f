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

/// Fewest views from which a calibration is attempted. Two would determine four parameters, with nothing left
/// to notice a mistake by.
inline constexpr int kMinViews = 3;

/// Fewest corners from which a view is used.
inline constexpr std::size_t kMinCornersPerView = 6;

/// The input of a calibration, checked and in order.
struct PreparedViews {
  std::vector<Board> boards;              ///< View::board is an index into these
  std::vector<View> views = {};           ///< in order of names and boards, corners in order of their ids;
                                          ///< FitView::source is an index into these
  std::vector<std::size_t> sources = {};  ///< of each, its index among those that were given
  Dropped dropped = {};                   ///< views with too few corners and repeated ones
};

/// Checks what was given, puts it in order, and leaves out views with too few corners and copies of others.
/// @throws Error (kInput), see calibrate()
[[nodiscard]] PreparedViews prepareViews(std::span<const Board> boards, std::vector<View> views);

/// The corners of each view, see observationsOf().
[[nodiscard]] std::vector<std::vector<Observation>> cornersOf(const PreparedViews& given);

/// The views that a fit does not use, in their order.
[[nodiscard]] std::vector<std::size_t> viewsLeftOut(const PreparedViews& given, const Fit& fit);

/// @throws Error (kInput) with the reasons of the views left out if the fit has fewer than kMinViews
void requireViews(const PreparedViews& given, const Fit& fit);

/// Makes one view of all views in which a board stands at the same place: duplicates of an image,
/// re-encoded or retouched, or a series from a tripod. The effects of lens, board shape and blur are the
/// same in all of them, and only the corners' noise may differ; taken for as many views they would feign
/// more certainty than there is and outweigh the rest.
///
/// The view keeps the first one's name (in order of names). Each corner is put at the median, axis by axis,
/// of where the group's views have it; its sigma stays that of one view.
///
/// Two views of one board repeat each other if they have most corners in common, and the corners'
/// displacements from one to the other, as far as they are an affine function of the place in the image, as a
/// change of pose makes them, are within kSamePlacePx and those that are left scatter by no more than noise
/// does.
/// @param given  with views in order of their names; those that repeat others go to `dropped`
void mergeRepeatedViews(PreparedViews& given);

/// How far apart corners may lie and still count as the same pose, RMS over the corners, px.
inline constexpr double kSamePlacePx = 0.25;

}  // namespace alidade
