// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/compare/difference_significance.h"
#include "alidade/compare/projection_difference.h"

namespace alidade {

/// What a difference means to someone who puts up with some of it.
enum class Agreement {
  kWithin,         ///< 95 % of the image agrees to the tolerance
  kBeyond,         ///< it does not, and the cameras' uncertainty is no excuse
  kUncertain,      ///< it does not, but two estimates of one camera may differ as much
  kNotComparable,  ///< too much of the image is seen by one of the cameras alone
};

/// Judged by the length that 95 % of the pixels do not exceed: a tolerance is meant for the image and not for
/// its worst pixel. Beyond the tolerance is a longer one if the difference is significant too. Without
/// significance, the cameras count as exact.
[[nodiscard]] Agreement agreementOf(const ProjectionDifference& difference,
                                    const std::optional<DifferenceSignificance>& significance,
                                    double tolerance_px);

/// Whether enough of the image could be compared to speak of it as a whole.
[[nodiscard]] bool isComparable(const ProjectionDifference& difference);

}  // namespace alidade
