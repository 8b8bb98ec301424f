// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include <Eigen/Core>

namespace alidade {

/// The smallest standard deviation assumed for a corner; it keeps the loss and the weights meaningful on
/// noise-free data.
inline constexpr double kMinSigmaPx = 0.003;

/// The error of a corner, with its standard deviation and leverage.
struct CornerResidual {
  double sigma_px;           ///< same as Corner::sigma_px
  Eigen::Vector2d error_px;  ///< of the reprojection, not weighted
  double leverage;           ///< see leverages()
};

/// The weight of each corner. The variance of a corner's coordinate is sigma^2 + tau^2: sigma is stated by
/// the detector. tau is the same for all corners and covers errors that the detector cannot know: a board
/// that is not flat, a lens that the model does not describe, printing errors. The weight of a corner is
/// inversely proportional to that variance, and the mean weight is 1.
///
/// Only ratios of variances matter to the estimate: their overall scale is estimated from the residuals. If
/// the stated sigmas are equal, or no sigma is stated, all weights are exactly 1.
class CornerNoise {
 public:
  /// Without sigmas: all weights are 1.
  CornerNoise() = default;
  /// Uses the given sigmas. An unknown sigma is replaced by the median of the known ones. All weights are 1
  /// until tau is estimated.
  explicit CornerNoise(std::span<const double> sigmas_px);

  /// True if any corner states a sigma.
  [[nodiscard]] bool isStated() const { return is_stated_; }
  /// True if all weights are exactly 1 for every tau.
  [[nodiscard]] bool isUniform() const { return is_uniform_; }
  /// Estimates tau from reprojection errors as a variance component by restricted maximum likelihood
  /// (Patterson and Thompson 1971), with squared errors clipped to limit the influence of outliers.
  void estimateUnexplained(std::span<const CornerResidual> corners);

  /// Relative weight of a corner whose detection states `sigma_px`; NaN = unknown.
  [[nodiscard]] double weight(double sigma_px) const;
  /// The variance in px^2 that is used for a stated sigma: bounded; the typical variance if unknown.
  [[nodiscard]] double statedVariance(double sigma_px) const;
  /// tau, px. 0 if the stated sigmas explain the errors or overstate them.
  [[nodiscard]] double unexplainedSigma() const;

 private:
  bool is_stated_ = false;
  bool is_uniform_ = true;
  bool is_estimated_ = false;
  double typical_sigma_px_ = kMinSigmaPx;
  double unexplained_variance_ = 0;  // tau^2, px^2
  double reference_variance_ = 0;    // variance of a corner of weight 1, px^2
};

}  // namespace alidade
