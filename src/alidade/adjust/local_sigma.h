// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/fit.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// Standard deviation of the coordinate of a corner of weight 1, px, from the differences of the errors of
/// corners that are neighbours on the board (von Neumann 1941, Distribution of the ratio of the mean square
/// successive difference to the variance). Noise that is independent from corner to corner gives the same as
/// the errors themselves; errors that vary smoothly give much less. NaN where no two neighbours were seen.
/// @param fit  of one board
[[nodiscard]] double localSigma(const Fit& fit);

/// Sums of the same over some views.
class NeighbourDifferences {
 public:
  explicit NeighbourDifferences(const Checkerboard& board);

  /// @param errors  one a corner, px, not weighted
  void add(std::span<const Observation> corners, std::span<const Eigen::Vector2d> errors);
  [[nodiscard]] double sigma() const;

 private:
  Checkerboard board_;
  std::vector<int> index_of_;
  double sum_ = 0;
  int num_pairs_ = 0;
};

}  // namespace alidade
