// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "alidade/compare/projection_difference.h"

namespace alidade {

/// A drawing (SVG) of the difference of two cameras over the image of the first: its length as colours, an
/// arrow from where a puts a point to where b does, the largest one marked, and pixels that cannot be
/// compared hatched, with a scale for all of it.
/// @param difference  of a grid, with what was taken out found
/// @param lines       of text to write under it
[[nodiscard]] std::string differenceSvg(const ComparedCamera& a, const ComparedCamera& b,
                                        const ProjectionDifference& difference,
                                        std::span<const std::string> lines);

}  // namespace alidade
