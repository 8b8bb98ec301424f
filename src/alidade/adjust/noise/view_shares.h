// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"

namespace alidade {

/// Deviation of each view from all views together, for statistics that assume only views to be independent.
///
/// The fit adapts to all views, so their pulls are too small, most of all for influential views. They are
/// scaled up (PullLift), and degrees of freedom are computed under independent noise: Bell and McCaffrey
/// 2002, Bias reduction in standard errors for linear regression with multi-stage samples, Survey Methodology
/// 28(2) ("CR2"); Imbens and Kolesar 2016, Robust standard errors in small samples, Review of Economics and
/// Statistics 98(4).
enum class PullLift {
  /// Makes their expected squares correct under independent noise: "CR2".
  kForNoise,
  /// As if the view had taken no part in the fit, like the jackknife: "CR3". The covariance is never too
  /// small, even if each view has its own camera or one view decides nearly everything.
  kLeaveOneOut
};

/// Variance of the sum of pulls over the sum of their variances, at least 1: more than 1 if pulls in
/// succession are alike beyond chance, as those of the frames of a video are. Pulls are taken for an
/// autoregressive process of first order, whose correlation is the mean over all directions.
/// @param pulls  M x views: deviations of each view, in the order in which they were taken
[[nodiscard]] double serialFactor(const Eigen::MatrixXd& pulls);

class ViewShares {
 public:
  /// @param pulls       one per view, at the optimum; columns as the rows of `directions`
  /// @param directions  free directions, one per column
  /// @param mean_slope  see meanSlope()
  /// @param prior       prior information, K x K for K rows of `directions`, per px^2; empty: none
  /// @returns nothing if there are no free directions, or the views do not determine them
  [[nodiscard]] static std::optional<ViewShares> make(std::span<const Reduced> pulls,
                                                      const Eigen::MatrixXd& directions, double mean_slope,
                                                      const Eigen::MatrixXd& prior = {},
                                                      PullLift lift = PullLift::kForNoise);

  /// K x M: the directions, scaled and mixed so that the information of all views is the identity.
  [[nodiscard]] const Eigen::MatrixXd& basis() const { return basis_; }
  /// M x M in that basis: the covariance from the disagreement of the views.
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// M x views, in that basis: the pulls whose squares are summed in the covariance, times the mean slope.
  [[nodiscard]] Eigen::MatrixXd pulls() const;
  /// Degrees of freedom of the variance of contrast . x, with x in that basis.
  [[nodiscard]] double freedomOf(const Eigen::VectorXd& contrast) const;
  /// Sum over the views of the squares of the elements of their shares: M divided by the number of views if
  /// all views are equally informative.
  [[nodiscard]] double squaresOfShares() const;

 private:
  // The share S, between 0 and 1, of a view in the information of all views.
  struct Share {
    Eigen::MatrixXd S;
    Eigen::MatrixXd lift;  // compensates for the adaptation of the fit to the view
    Eigen::VectorXd pull;  // after the lift
  };
  static Share shareOf(const Reduced& view, const Eigen::MatrixXd& basis, PullLift lift);

  Eigen::MatrixXd basis_;
  std::vector<Share> shares_;
  Eigen::MatrixXd covariance_;
};

}  // namespace alidade
