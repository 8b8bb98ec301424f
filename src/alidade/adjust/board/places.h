// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "alidade/adjust/board/reduced.h"

namespace alidade {

/// The place of the board in each view, numbered from 0 in the order of the views. A view belongs to a place
/// of the same board if its corners lie, as root mean square, within 0.5 % of the image diagonal of those of
/// the place's first view. Frames of a video in which the board is at rest share blur, lens and board errors,
/// so they count as one view where views are assumed to be independent.
[[nodiscard]] std::vector<std::size_t> placesOf(const Fit& fit);

[[nodiscard]] std::size_t numPlaces(const Fit& fit);

/// The equations of each place: the sum of those of its views.
[[nodiscard]] std::vector<Reduced> sumByPlace(std::vector<Reduced> views,
                                              std::span<const std::size_t> places);

/// Same as reduced(), but one per place.
[[nodiscard]] std::vector<Reduced> reducedByPlace(const Fit& fit, LossWeights weights);

}  // namespace alidade
