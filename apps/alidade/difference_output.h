// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/validate/difference_significance.h"
#include "alidade/validate/projection_difference.h"

namespace alidade {

/// The motion that was taken out, the figures and a table of the grid, for people.
[[nodiscard]] std::string differenceText(const ProjectionDifference& difference);

/// "the difference of 0.4 px (RMS) is 1.2 sigma: not significant; ...", or why nobody can tell.
[[nodiscard]] std::string significanceText(const ProjectionDifference& difference,
                                           const std::optional<DifferenceSignificance>& significance,
                                           bool has_a, bool has_b);

/// All of it; what is not finite is null.
[[nodiscard]] nlohmann::json differenceJson(const ProjectionDifference& difference,
                                            const std::optional<DifferenceSignificance>& significance);

}  // namespace alidade
