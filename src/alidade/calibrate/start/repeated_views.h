// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/target/view.h"

namespace alidade {

/// Makes one view of all views in which the board stands at the same place: copies of an image, a stored
/// again or a retouched one, a series from a tripod. What the lens, the board's shape and blur do there is
/// the same in all of them, and only the corners' noise may differ; taken for as many views they would feign
/// more certainty than there is and outweigh the rest.
///
/// The view keeps the first one's name (in order of names). Each corner is put at the median, axis by axis,
/// of where the group's views have it; its sigma stays that of one view.
///
/// Two views repeat each other if they have most corners in common, and the corners' displacements from one
/// to the other, as far as they are an affine function of the place in the image, as a change of pose makes
/// them, are within kSamePlacePx and those that are left scatter by no more than noise does.
/// @param given  with views in order of their names; those that repeat others go to `repeated`
void mergeRepeatedViews(PreparedViews& given);

/// How far apart corners of the same pose may lie for the pose's sake, RMS over the corners, px.
inline constexpr double kSamePlacePx = 0.25;

}  // namespace alidade
