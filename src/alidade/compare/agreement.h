// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/compare/difference_significance.h"
#include "alidade/compare/projection_difference.h"

namespace alidade {

/// The result of comparing a difference with a tolerance.
enum class Agreement {
  kWithin,         ///< 95 % of the image agrees within the tolerance
  kBeyond,         ///< it does not, and uncertainty does not explain the difference
  kUncertain,      ///< it does not, but the uncertainty explains the difference
  kNotComparable,  ///< too much of the image is seen by only one of the cameras
};

/// Compares the 95th percentile of the difference with the tolerance, because a tolerance applies to the
/// image and not to its worst pixel. A larger difference is kBeyond only if it is significant. If the
/// significance is unknown, the cameras are assumed to be exact.
[[nodiscard]] Agreement agreementOf(const ProjectionDifference& difference,
                                    const std::optional<DifferenceSignificance>& significance,
                                    double tolerance_px);

/// Whether enough of the image could be compared to judge it as a whole.
[[nodiscard]] bool isComparable(const ProjectionDifference& difference);

}  // namespace alidade
