// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "alidade/compare/projection_difference.h"

namespace alidade {

/// Whether a difference is more than the uncertainty of the two cameras makes it.
struct DifferenceSignificance {
  /// One a pixel, px: one standard deviation of the difference along the direction in which it is largest;
  /// NaN where there is no difference.
  std::vector<double> std_px;
  double expected_rms_px = 0;  ///< root of the mean square difference that the covariances lead to expect
  /// The difference in standard deviations: the normal variable that is exceeded as often as the sum of its
  /// squares over all directions into which the cameras' uncertainty moves it (Wald's statistic).
  double sigmas = 0;
  /// What is left of p95_px, px, at the camera nearest to a, on the way from a to b, that chance makes in
  /// more than 1 of 1000 cases: the part of the difference that is sure. 0 where it is not significant.
  double sure_p95_px = 0;
  double share_beyond =
      0;  ///< of the compared pixels, of those outside of their 95 % ellipse; 0.05 by chance

  /// Exceeded by chance in 1 of 1000 cases.
  [[nodiscard]] bool isSignificant() const;
};

/// Carries the covariances of both cameras to the difference (differenceFactor). A camera without covariance
/// counts as exact; nothing if neither has one.
[[nodiscard]] std::optional<DifferenceSignificance> significanceOf(const ProjectionDifference& difference,
                                                                   const ComparedCamera& a,
                                                                   const ComparedCamera& b,
                                                                   std::optional<Freed> freed);

}  // namespace alidade
