// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "alidade/validate/projection_difference.h"

namespace alidade {

/// Whether a difference is more than the uncertainty of the two cameras makes it.
struct DifferenceSignificance {
  /// One a pixel, px: one standard deviation of the difference along the direction in which it is largest;
  /// NaN where there is no difference.
  std::vector<double> std_px;
  double expected_rms_px = 0;  ///< root of the mean square difference that the covariances lead to expect
  /// 95 % of the compared pixels differ by at most this much more than two standard deviations, px: what is
  /// left of the difference where the cameras are given the benefit of the doubt.
  double sure_p95_px = 0;
  /// The difference in the whole image in standard deviations: the normal variable that is exceeded as
  /// often. Each pixel counts by its own uncertainty, so that where the cameras are known well counts most.
  double sigmas = 0;
  double share_beyond =
      0;  ///< of the compared pixels, of those outside of their 95 % ellipse; 0.05 by chance

  /// Exceeded by chance in 1 of 100 cases.
  [[nodiscard]] bool isSignificant() const;
};

/// Carries the covariances of both cameras to the difference (differenceFactor). A camera without covariance
/// counts as exact; nothing if neither has one.
///
/// The mean square of the differences over their standard deviations, which are correlated, is taken for a
/// multiple of chi square (Satterthwaite 1946, An approximate distribution of estimates of variance
/// components, Biometrics Bulletin 2(6)).
[[nodiscard]] std::optional<DifferenceSignificance> significanceOf(const ProjectionDifference& difference,
                                                                   const ComparedCamera& a,
                                                                   const ComparedCamera& b,
                                                                   std::optional<Freed> freed);

}  // namespace alidade
