// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "alidade/compare/projection_difference.h"

namespace alidade {

/// Whether a difference is larger than the uncertainty of the two cameras explains.
struct DifferenceSignificance {
  /// One per pixel, px: standard deviation of the difference along the direction in which it is largest; NaN
  /// where there is no difference.
  std::vector<double> std_px;
  double expected_rms_px = 0;  ///< RMS difference that the covariances predict
  /// The difference in standard deviations: the normal variable that is exceeded as often as the sum of its
  /// squares over all directions into which the cameras' uncertainty moves it (Wald's statistic).
  double sigmas = 0;
  /// The part of p95_px that chance does not explain: p95 between a and the camera nearest to it,
  /// on the way from a to b, from which b differs by chance in 1 of 1000 cases. 0 if not
  /// significant.
  double sure_p95_px = 0;
  double share_beyond =
      0;  ///< of the compared pixels, of those outside of their 95 % ellipse; 0.05 by chance

  /// Exceeded by chance in 1 of 1000 cases.
  [[nodiscard]] bool isSignificant() const;
};

/// Propagates the covariances of both cameras to the difference (differenceFactor). A camera without
/// covariance is assumed to be exact; nothing if neither has one.
[[nodiscard]] std::optional<DifferenceSignificance> significanceOf(const ProjectionDifference& difference,
                                                                   const ComparedCamera& a,
                                                                   const ComparedCamera& b,
                                                                   std::optional<Freed> freed);

}  // namespace alidade
