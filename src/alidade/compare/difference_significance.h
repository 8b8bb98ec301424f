// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/compare/projection_difference.h"

namespace alidade {

/// F, 2 rows per pixel, px of the finer image along a's axes: to first order F F^T is the covariance of the
/// differences caused by the uncertainty of the two cameras, with the alignment refitted for every change of
/// the parameters. A camera without covariance is assumed to be exact; without any covariance, F has no
/// columns.
/// @param pixels   of image a, all with a ray in either camera
/// @param weights  of the pixels in the alignment; empty: all equal
[[nodiscard]] Eigen::MatrixXd differenceFactor(const ComparedCamera& a, const ComparedCamera& b,
                                               const ImageMatch& match,
                                               std::span<const Eigen::Vector2d> pixels,
                                               std::optional<Freed> freed, std::span<const double> weights);

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
