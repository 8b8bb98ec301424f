// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/compare/difference_significance.h"
#include "alidade/compare/projection_difference.h"

namespace alidade {

/// The motion that was taken out and the figures, for people; that there are none where
/// the motion was not found.
[[nodiscard]] std::string differenceText(const ProjectionDifference& difference);

/// A note for images whose sizes differ by more than a factor, as where a side was rounded (213x160 of
/// 640x480): how many pixels of the finer one that leaves. Empty for those that have exactly one shape.
/// @pre the images have one shape but for rounding, see possibleTurns()
[[nodiscard]] std::string unevenSizeText(ImageSize a, ImageSize b, int quarter_turns);

/// Rows of text for people ("Removed  a rotation", continued on lines that begin with blanks) as lines for a
/// figure: "Removed: a rotation".
[[nodiscard]] std::vector<std::string> figureLines(const std::string& text);

/// A table of the grid's lengths, for people.
[[nodiscard]] std::string differenceTable(const ProjectionDifference& difference);

/// "the difference of 0.4 px (RMS) is 1.2 sigma: not significant; ...", or why nobody can tell.
[[nodiscard]] std::string significanceText(const ProjectionDifference& difference,
                                           const std::optional<DifferenceSignificance>& significance,
                                           bool has_a, bool has_b);

/// All of it; what is not finite is null, and so are all figures where the motion was not found.
[[nodiscard]] nlohmann::json differenceJson(const ProjectionDifference& difference,
                                            const std::optional<DifferenceSignificance>& significance);

}  // namespace alidade
