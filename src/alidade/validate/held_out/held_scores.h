// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"
#include "alidade/adjust/noise/view_shares.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/camera_change.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// Views, posed for a camera, with their errors.
struct PosedViews {
  Fit fit;  ///< of one camera, without a loss
  /// How much each view counts: best the inverse of the variance of its corners. Empty: all alike.
  std::vector<double> weights;
};

/// Errors of this size an axis, px, count as chance even where corners are without noise: what is left of
/// those is rounding, and how a change compares with it says nothing.
inline constexpr double kFinestPx = 1e-3;

/// Whether a camera is off by so much that the refitted poses cannot hide it: how improbable the ratio of its
/// squared errors to those of the freed camera would be if it were right, as a normal variable.
///
/// An F test in which corners do not count, only views: what the corners of a view have in common (blur,
/// motion, a rolling shutter) shears and stretches it as a whole, which is four numbers, of which its pose
/// takes most. Each view adds two degrees of freedom, however many corners it has; the freed parameters
/// take theirs away. With few views none remain, and the result is 0. With noise alone, which is far more
/// numbers a view, the test is far on the safe side.
/// @param held   posed for the camera as it is
/// @param freed  the same views, posed for the camera that they give
[[nodiscard]] double misfitSigmas(const PosedViews& held, const PosedViews& freed);

/// The views refitted to another camera, from where they are; nothing where it does not see one of them.
[[nodiscard]] std::optional<PosedViews> posedFor(const AnyCamera& camera, PosedViews views);

/// By how much a camera would have to be changed in one way, and in no other, to suit images best.
struct StepEstimate {
  double amount = 0;   ///< to first order
  double std = 0;      ///< one standard deviation of it
  double freedom = 0;  ///< degrees of freedom of `std`
  /// The normal variable that is as improbable as such an amount, of either sign, for the right camera; not
  /// negative.
  double sigmas = 0;
  /// sqrt(mean of dx^2 + dy^2) over all corners, poses refitted; NaN where the change was not made.
  double rms_px = std::numeric_limits<double>::quiet_NaN();

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

  std::vector<Reduced> pulls_;   // weighted
  Eigen::MatrixXd information_;  // of all views
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd noise_;             // what the corners' noise makes of the gradient's covariance
  std::optional<ViewShares> shares_;  // with all parameters free
  std::optional<double> excess_;      // variance by the views over that by noise, over all directions
  std::optional<DenseMatrix> covariance_;
};

/// Ways in which intrinsics are wrong as a whole, one number saying by how much: a file of another zoom or
/// focus, of a crop, of a lens like it, or with the pixel's origin at its corner.
inline constexpr std::array kIntrinsicsChanges = {CameraChangeKind::kFocalLength, CameraChangeKind::kCenterX,
                                                  CameraChangeKind::kCenterY, CameraChangeKind::kDistortion,
                                                  CameraChangeKind::kPixelOrigin};

/// The change of the parameters per amount of 1; empty for a camera that has nothing of the kind, and for a
/// distortion in no proportion to its coefficients.
[[nodiscard]] Eigen::VectorXd directionOf(CameraChangeKind change, const AnyCamera& camera);

/// The camera changed by `amount`; nothing where its parameters would leave their range.
[[nodiscard]] std::optional<AnyCamera> changed(const AnyCamera& camera, CameraChangeKind change,
                                               double amount);

/// What is wrong with a camera that would have to be changed by `amount`, in words: "its focal length is
/// 1.02 +- 0.05 % too long".
[[nodiscard]] std::string complaintOf(CameraChangeKind change, double amount, double std);

/// The amounts of directions in which a camera is nearest to the freed one, as the views count: near the
/// freed camera the sum of squared errors is a parabola, however far the first one is from it.
/// @param open  N x M: a direction a column
[[nodiscard]] Eigen::VectorXd amountsToFreed(const AnyCamera& camera, const Eigen::MatrixXd& open,
                                             const PosedViews& freed);

/// One way to change a camera, taken until nothing more is gained by it: the first step alone, which a score
/// test takes, falls far short where the camera is far off. The estimate is of the change in all, its
/// uncertainty that where it has come to rest. The other parameters are as in HeldScores::make().
/// @returns nothing where the views say nothing of the change, or where it leads to a camera that cannot be
/// or does not see the boards
[[nodiscard]] std::optional<StepEstimate> refitChange(const AnyCamera& tested, CameraChangeKind change,
                                                      const PosedViews& freed, double noise_variance,
                                                      const std::optional<DenseMatrix>& covariance);

/// A slip that a camera file may contain, and the camera without it.
struct Slip {
  std::string_view id;  ///< stable, for scripts: "k1_sign"
  std::string text;     ///< with the numbers: "k1 has the wrong sign: k1 -0.28 instead of 0.28"
  AnyCamera mended;
  int num_free = 0;   ///< numbers of the mended camera that were taken from the images
  double rms_px = 0;  ///< sqrt(mean of dx^2 + dy^2) over all corners, poses refitted to the mended camera
};

/// Mends each slip of the list that the numbers of a camera allow. Numbers that the slip leaves open, such as
/// a wrong fy, come from the freed camera; nothing else is fitted but poses.
/// @param freed  posed for the camera that the views give
/// @returns those with which all corners can be seen
[[nodiscard]] std::vector<Slip> mendedSlips(const AnyCamera& tested, const PosedViews& freed);

}  // namespace alidade
