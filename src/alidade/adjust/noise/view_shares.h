// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"

namespace alidade {

/// What each view says beside what all say together, for statements that take only views for independent.
///
/// The fit has drawn all views towards itself, so that their pulls are too small, those of views with much
/// say most. They are scaled up, see PullLift, and degrees of freedom are found under independent noise: Bell
/// and McCaffrey 2002, Bias reduction in standard errors for linear regression with multi-stage samples,
/// Survey Methodology 28(2) ("CR2"); Imbens and Kolesar 2016, Robust standard errors in small samples, Review
/// of Economics and Statistics 98(4).
enum class PullLift {
  /// So that under independent noise their expected squares are right: "CR2".
  kForNoise,
  /// As if the view had had no part in the fit: the jackknife's, "CR3". The covariance is never too
  /// small, even where every view has a camera of its own and one view decides nearly all.
  kLeaveOneOut
};

class ViewShares {
 public:
  /// @param pulls       one a view, at the optimum; columns as the rows of `directions`
  /// @param directions  what is free, one direction a column
  /// @param mean_slope  see meanSlope()
  /// @param prior       what is known besides the views, K x K for K rows of `directions`, per px^2; empty:
  ///                    nothing
  /// @returns nothing where the views do not determine what is free, or nothing is
  [[nodiscard]] static std::optional<ViewShares> make(std::span<const Reduced> pulls,
                                                      const Eigen::MatrixXd& directions, double mean_slope,
                                                      const Eigen::MatrixXd& prior = {},
                                                      PullLift lift = PullLift::kForNoise);

  /// K x M: the directions scaled and mixed so that the information of all views is the identity.
  [[nodiscard]] const Eigen::MatrixXd& basis() const { return basis_; }
  /// M x M in that basis: the covariance that the views' disagreement gives.
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// Degrees of freedom of the variance of contrast . x, x being in that basis.
  [[nodiscard]] double freedomOf(const Eigen::VectorXd& contrast) const;
  /// Sum over the views of the squares of the elements of their shares: 1 over the number of views that say
  /// equally much, times M.
  [[nodiscard]] double squaresOfShares() const;

 private:
  // A view says the share S, between 0 and 1, of what all views together say.
  struct Share {
    Eigen::MatrixXd S;
    Eigen::MatrixXd lift;  // what makes up for the fit's having been drawn towards the view
    Eigen::VectorXd pull;  // lifted
  };
  static Share shareOf(const Reduced& view, const Eigen::MatrixXd& basis, PullLift lift);

  Eigen::MatrixXd basis_;
  std::vector<Share> shares_;
  Eigen::MatrixXd covariance_;
};

}  // namespace alidade
