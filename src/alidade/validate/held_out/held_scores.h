// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/reduced.h"
#include "alidade/adjust/view_shares.h"
#include "alidade/camera/any_camera.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// Views, posed for a camera.
struct PosedViews {
  Fit fit;  ///< of one camera, without a loss
  /// How much each view counts: best the inverse of the variance of its corners. Empty: all alike.
  std::vector<double> weights;
};

/// By how much a camera would have to be changed in one way, and in no other, to suit images best.
struct StepEstimate {
  double amount = 0;   ///< to first order
  double std = 0;      ///< one standard deviation of it
  double freedom = 0;  ///< degrees of freedom of `std`
  /// The normal variable that is as improbable as such an amount, of either sign, for the right camera; not
  /// negative.
  double sigmas = 0;

  [[nodiscard]] bool isSignificant() const;
  /// Half the width of the 95 % interval over 1.96: one standard deviation that can be used like one of a
  /// normal variable.
  [[nodiscard]] double effectiveStd() const;
};

/// Whether any change of the camera at all would suit images better than chance does.
struct OverallTest {
  double sigmas = 0;  ///< the normal variable that is exceeded as often by the right camera
  /// The share of the change in question that is beyond chance, 0 to 1.
  double sure_share = 0;

  [[nodiscard]] bool isSignificant() const;
};

/// What views that a camera was not made from say against it while it is held as it is: score tests, in which
/// nothing but the poses is fitted to the images.
///
/// Only views count as independent of each other, whatever the corners of one view have in common (Cameron
/// and Miller 2015, A practitioner's guide to cluster-robust inference, Journal of Human Resources 50(2)).
/// With few views see ViewShares for how far their disagreement can be trusted. The variance of a single
/// change, and the mean variance of all, are not taken for less than the corners' noise makes them, and what
/// the camera's own uncertainty contributes is added.
class HeldScores {
 public:
  /// @param held   posed for the camera as it is
  /// @param freed  the same views, posed for the camera that they give by themselves, by which their
  ///               disagreement is measured; nothing: by the camera that is one step away from the held one,
  ///               near which the two are the same
  /// @param noise_variance  of the coordinate of a corner of weight 1, px^2; positive
  /// @param covariance      of the camera's parameters, N x N; nothing, or a matrix that is none: they count
  ///                        as exact
  /// @returns nothing for less than three views, or views that say nothing of the parameters
  [[nodiscard]] static std::optional<HeldScores> make(const AnyCamera& camera, const PosedViews& held,
                                                      const PosedViews* freed, double noise_variance,
                                                      std::optional<DenseMatrix> covariance);

  /// Of one change by itself: a statement of one number, for which a few views suffice where an estimate of
  /// all parameters would be lost in their uncertainty. Nothing where the views say nothing of it.
  /// @param direction  N: the change of the parameters per amount of 1
  [[nodiscard]] std::optional<StepEstimate> along(const Eigen::VectorXd& direction) const;

  /// Of all parameters at once. The views are too few for a covariance in so many dimensions: their
  /// disagreement counts as one factor on the variance by noise, and how unevenly it lies over the directions
  /// goes into the degrees of freedom (Satterthwaite 1946, An approximate distribution of estimates of
  /// variance components, Biometrics Bulletin 2(6)).
  [[nodiscard]] OverallTest overall() const;

 private:
  HeldScores() = default;

  // How many views there were if all said equally much.
  [[nodiscard]] double numEqualViews() const;

  std::vector<Reduced> pulls_;   // weighted
  Eigen::MatrixXd information_;  // of all views
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd noise_;             // what the corners' noise makes of the gradient's covariance
  std::optional<ViewShares> shares_;  // with all parameters free
  std::optional<double> excess_;      // variance by the views over that by noise, over all directions
  std::optional<DenseMatrix> covariance_;
};

}  // namespace alidade
