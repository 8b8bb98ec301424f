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
  /// Weight of each view, ideally the inverse of the variance of its corners. Empty: all equal.
  std::vector<double> weights;
};

/// Errors of this size per axis, px, count as chance even without corner noise: the remainder is rounding,
/// and comparing a change with rounding means nothing.
inline constexpr double kFinestPx = 1e-3;

/// Evidence that a camera is off by so much that refitted poses cannot hide it: how improbable the ratio of
/// its squared errors to those of the freed camera would be for the right camera, as a normal variable.
///
/// An F test that counts views and not corners: errors common to the corners of a view (blur, motion, a
/// rolling shutter) shear and stretch it as a whole. That is four numbers, and its pose absorbs most of them.
/// Each view adds two degrees of freedom, however many corners it has; the freed parameters subtract theirs.
/// With few views none remain, and the result is 0. With pure noise, which has far more numbers per view, the
/// test is very conservative.
/// @param held   posed with the unchanged camera
/// @param freed  the same views, posed with the camera calibrated from them
[[nodiscard]] double misfitSigmas(const PosedViews& held, const PosedViews& freed);

/// The views refitted to a different camera from their current poses; nothing if it does not see one of them.
[[nodiscard]] std::optional<PosedViews> posedFor(const AnyCamera& camera, PosedViews views);

/// Amount of one single change to a camera that fits images best.
struct StepEstimate {
  double amount = 0;   ///< to first order
  double std = 0;      ///< one standard deviation of `amount`
  double freedom = 0;  ///< degrees of freedom of `std`
  /// The normal variable, not negative, that is as improbable as an amount of this size and either sign for
  /// the right camera.
  double sigmas = 0;
  /// sqrt(mean of dx^2 + dy^2) over all corners with refitted poses; NaN if the change was not made.
  double rms_px = std::numeric_limits<double>::quiet_NaN();

  [[nodiscard]] bool isSignificant() const;
  /// Half the width of the 95 % interval over 1.96: one standard deviation that can be used like one of a
  /// normal variable.
  [[nodiscard]] double effectiveStd() const;
};

/// Test whether any change of the camera would fit images better than chance.
struct OverallTest {
  double sigmas = 0;  ///< normal variable that is as improbable for the right camera
  /// The share of the change in question that is beyond chance, 0 to 1.
  double sure_share = 0;

  [[nodiscard]] bool isSignificant() const;
};

/// Evidence of views that a camera was not made from against the unchanged camera: score tests, in which only
/// the poses are fitted to the images.
///
/// Views count as independent of each other; the corners of one view may share errors (Cameron and Miller
/// 2015, A practitioner's guide to cluster-robust inference, Journal of Human Resources 50(2)). With few
/// views see ViewShares for the reliability of their disagreement. The variance of a single change, and the
/// mean variance of all, are at least those of the corners' noise, and the camera's own uncertainty is added.
class HeldScores {
 public:
  /// @param held   posed with the unchanged camera
  /// @param freed  the same views, posed for the camera that they give by themselves, by which their
  ///               disagreement is measured; nothing: by the camera that is one step away from the held one,
  ///               near which the two are the same
  /// @param noise_variance  of the coordinate of a corner of weight 1, px^2; positive
  /// @param covariance      of the camera's parameters, N x N; nothing, or a matrix that is none: they count
  ///                        as exact
  /// @returns nothing for fewer than three views, or views that do not constrain the parameters
  [[nodiscard]] static std::optional<HeldScores> make(const AnyCamera& camera, const PosedViews& held,
                                                      const PosedViews* freed, double noise_variance,
                                                      std::optional<DenseMatrix> covariance);

  /// Test of one change by itself: one number, for which a few views suffice although they cannot estimate
  /// all parameters. Nothing if the views do not constrain it.
  /// @param direction  N: the change of the parameters per amount of 1
  [[nodiscard]] std::optional<StepEstimate> along(const Eigen::VectorXd& direction) const;

  /// Test of all parameters at once. The views are too few for a covariance in so many dimensions: their
  /// disagreement becomes one factor on the variance by noise, and its unevenness over directions reduces the
  /// degrees of freedom (Satterthwaite 1946, An approximate distribution of estimates of variance components,
  /// Biometrics Bulletin 2(6)).
  [[nodiscard]] OverallTest overall() const;

 private:
  HeldScores() = default;

  std::vector<Reduced> pulls_;   // weighted
  Eigen::MatrixXd information_;  // of all views
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd noise_;             // covariance of the gradient by corner noise
  std::optional<ViewShares> shares_;  // with all parameters free
  std::optional<double> excess_;      // variance by the views over that by noise, over all directions
  std::optional<DenseMatrix> covariance_;
};

/// Ways in which intrinsics may be wrong as a whole, by one number each: a file for a different zoom or
/// focus, for a crop, for a similar lens, or with the pixel origin at the corner.
inline constexpr std::array kIntrinsicsChanges = {CameraChangeKind::kFocalLength, CameraChangeKind::kCenterX,
                                                  CameraChangeKind::kCenterY, CameraChangeKind::kDistortion,
                                                  CameraChangeKind::kPixelOrigin};

/// The change of the parameters per amount of 1; empty for a camera without such parameters, and for a
/// distortion that is not proportional to its coefficients.
[[nodiscard]] Eigen::VectorXd directionOf(CameraChangeKind change, const AnyCamera& camera);

/// The camera changed by `amount`; nothing if its parameters would leave their range.
[[nodiscard]] std::optional<AnyCamera> changed(const AnyCamera& camera, CameraChangeKind change,
                                               double amount);

/// The error of a camera that needs a change by `amount`, in words: "its focal length is 1.02 +- 0.05 % too
/// long".
[[nodiscard]] std::string complaintOf(CameraChangeKind change, double amount, double std);

/// The amounts along directions at which a camera is nearest to the freed one, weighted by the views: near
/// the freed camera the sum of squared errors is a parabola, however far away the tested camera is.
/// @param open  N x M: one direction per column
[[nodiscard]] Eigen::VectorXd amountsToFreed(const AnyCamera& camera, const Eigen::MatrixXd& open,
                                             const PosedViews& freed);

/// Changes a camera in one way until there is no further gain: the single step of a score test falls far
/// short if the camera is far off. The estimate is the total change, with the uncertainty at the final
/// camera. The other parameters are as in HeldScores::make().
/// @returns nothing if the views do not constrain the change, or if it leads to an invalid camera or one that
/// does not see the boards
[[nodiscard]] std::optional<StepEstimate> refitChange(const AnyCamera& tested, CameraChangeKind change,
                                                      const PosedViews& freed, double noise_variance,
                                                      const std::optional<DenseMatrix>& covariance);

/// A slip that a camera file may contain, and the camera without it.
struct Slip {
  std::string_view id;  ///< stable, for scripts: "k1_sign"
  std::string text;     ///< with the numbers: "k1 has the wrong sign: k1 -0.28 instead of 0.28"
  AnyCamera mended;
  int num_free = 0;   ///< numbers of the corrected camera that were taken from the images
  double rms_px = 0;  ///< sqrt(mean of dx^2 + dy^2) over all corners, poses refitted to the mended camera
};

/// Corrects each slip of the list that the numbers of a camera allow. Numbers that the slip leaves open, such
/// as a wrong fy, come from the freed camera; otherwise only poses are fitted.
/// @param freed  posed with the camera calibrated from the views
/// @returns those with which all corners can be seen
[[nodiscard]] std::vector<Slip> mendedSlips(const AnyCamera& tested, const PosedViews& freed);

}  // namespace alidade
