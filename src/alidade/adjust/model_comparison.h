// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "alidade/adjust/cross_validation.h"

namespace alidade {

/// Held-out errors view by view, as they are compared.
struct HeldOutScore {
  std::vector<double> of_view;  ///< sum of rho over a view's corners, px^2 of a corner of weight 1
  double sum = 0;               ///< over all views
};

/// What a corner counts that is not seen at all: as if it were off by ten thresholds of the loss.
[[nodiscard]] double farOff(HuberLoss loss);

/// What is added to the squares of so many corners, so that rounding decides nothing where they fit
/// perfectly: no corner is known better than kMinSigmaPx.
[[nodiscard]] double noiseFloor(std::size_t num_corners);

/// A corner that is not seen counts as far off.
/// @param fit  whose corners the errors are
[[nodiscard]] HeldOutScore scoreOf(const HeldOutErrors& errors, const Fit& fit);

/// How much larger one model's held-out errors are than another's on the same corners.
struct HeldOutExcess {
  double share = 0;             ///< of the other's held-out RMS; negative: they are smaller
  double std = 0;               ///< its standard error, by how much the views differ in it
  bool is_significant = false;  ///< see excessOf()
  double proven_share = 0;      ///< the share as far as it is significant, for isWorth()

  /// Significantly larger, and by enough to be worth so many further parameters.
  [[nodiscard]] bool isWorth(std::size_t num_further_params) const;
};

/// The paired comparison of two models view by view: corners of one view have its pose and its mistakes in
/// common, so that views are what varies independently. Significant is a difference of the views' sums of
/// squares, or else a factor between them, each larger than by chance in 19 of 20 cases (one-sided; one of
/// the two by chance in about 1 of 15). Where a model misses the lens by pixels, one view's sum may be larger
/// than all others', and a few views then differ too much for their mean to be told from zero, although every
/// one of them says the same. What the factors prove is no more than their mean.
/// @param a,b  of the same views and corners
[[nodiscard]] HeldOutExcess excessOf(const HeldOutScore& a, const HeldOutScore& b);

/// What a further parameter must take off the held-out RMS, as a share of it; see docs/model_choice.md.
inline constexpr double kShareOfParameter = 0.005;

}  // namespace alidade
