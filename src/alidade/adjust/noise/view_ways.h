// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// The ways in which a view may differ from the others.
enum class ViewWay {
  kFocal,    ///< both focal lengths, by a factor
  kShear,    ///< the image, from row to row: per pixel below the centre
  kStretch,  ///< the same along the columns
  kBendX,    ///< the board, metres; see BoardShape
  kBendY,
};
inline constexpr int kNumWays = 5;
inline constexpr std::array kFocalWay = {ViewWay::kFocal};
inline constexpr std::array kRowWays = {ViewWay::kShear, ViewWay::kStretch};
inline constexpr std::array kRowAndBendWays = {ViewWay::kShear, ViewWay::kStretch, ViewWay::kBendX,
                                               ViewWay::kBendY};
inline constexpr std::array kBendWays = {ViewWay::kBendX, ViewWay::kBendY};

/// Decrease of the sum of squares if each view has its own values, and the degrees of freedom of these.
struct WayDrop {
  double squares = 0;
  int freedom = 0;
};

/// What each view says about its own ways, with its pose free and the intrinsics held.
class ViewWays {
 public:
  explicit ViewWays(const Fit& fit);

  /// False if there are hardly more corners than unknowns, with so many ways free.
  [[nodiscard]] bool isRedundant(int num_ways) const;
  [[nodiscard]] WayDrop dropBy(std::span<const ViewWay> ways) const;
  /// Variance of a coordinate, px^2, that is left after a drop.
  [[nodiscard]] double varianceLeft(const WayDrop& drop) const;
  /// F statistic of a drop against the remaining squares; of its part beyond a smaller one. Only poses are
  /// free and, in total, as many values as the camera has parameters.
  [[nodiscard]] double f(const WayDrop& drop, const WayDrop& beyond = {}) const;
  /// The variance of one way between views without the contribution of noise, see ViewVariations.
  [[nodiscard]] double varianceOf(ViewWay way, double noise_variance) const;

 private:
  struct OfView {
    Eigen::Matrix<double, kNumWays, kNumWays> information;
    Eigen::Matrix<double, kNumWays, 1> gradient;
  };
  static WayDrop dropBy(const OfView& view, std::span<const ViewWay> ways);

  std::vector<OfView> views_;
  double squares_ = 0;
  int freedom_ = 0;
};

}  // namespace alidade
