// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/compare/projection_difference.h"
#include "alidade/core/cancel.h"
#include "alidade/core/diagnosis.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board.h"
#include "alidade/target/corner_error.h"
#include "alidade/target/view.h"
#include "alidade/validate/held_out/held_scores.h"

namespace alidade {

struct HeldOutOptions {
  /// The tested camera's covariance assumes only that views are independent; false: it is by corner noise
  /// alone.
  bool is_covariance_by_views = false;
  int jobs = 1;  ///< threads, 0: one per processor; the answer is bit-identical
  const CancelFlag* cancel = nullptr;
};

/// A view of the board, as seen by the tested camera.
struct HeldOutView {
  std::string image;
  std::size_t board = 0;    ///< see View
  bool is_testable = true;  ///< see isTestable()
  int num_corners = 0;      ///< those with an error
  int num_unseen = 0;       ///< that the camera cannot see from the pose of the others
  double rms_px = std::numeric_limits<double>::quiet_NaN();
  /// RMS of all corners with the pose fitted to all of them, px: of the unchanged camera, and of the freed
  /// one.
  double fixed_rms_px = std::numeric_limits<double>::quiet_NaN();
  double freed_rms_px = std::numeric_limits<double>::quiet_NaN();
  SE3 camera_from_board = {};  ///< fitted to all corners, for the unchanged camera
  /// Corners with an error, in ascending order of id; none was used for the pose that predicts it.
  std::vector<CornerError> corners = {};
};

/// A change of one parameter that the images suggest.
struct NeededChange {
  CameraChangeKind change;
  StepEstimate estimate;
  /// The projection difference that the change makes where the boards were, after removing the best rotation:
  /// 95 %; infinity if the changed camera is invalid or cannot be compared. NaN if it is not even a hint.
  double p95_px = std::numeric_limits<double>::quiet_NaN();
  /// The change iterated to convergence, if it is a hint; `estimate` is only its first step. Nothing if it
  /// does not converge.
  std::optional<StepEstimate> refined = std::nullopt;

  /// True if worth mentioning: beyond two standard deviations.
  [[nodiscard]] bool isHint() const { return estimate.sigmas > 2; }
};

/// The result of a test on images that the camera was not made from.
struct HeldOutJudgement {
  int num_views_given = 0;
  std::vector<HeldOutView> views;  ///< those used, in order of image name
  /// sqrt(mean of dx^2 + dy^2) over corners not used for their view's pose, px. NaN if there are none.
  double held_out_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// One standard deviation per axis of the noise between neighbouring corners, of the unchanged camera or of
  /// the freed one, whichever is smaller, because a camera that is far off does not measure noise. NaN
  /// without neighbours.
  double noise_sigma_px = std::numeric_limits<double>::quiet_NaN();
  /// held_out_rms_px for that noise alone.
  double noise_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// The camera of the same model calibrated from these images alone; nothing if that fails.
  std::optional<Calibration> freed;
  std::string freed_complaint;  ///< reason why there is none
  /// RMS of all corners with the poses fitted to all of them, px, for the unchanged camera.
  double fixed_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// From the camera to the freed one, after removing the best rotation, where the boards were; nothing
  /// without a freed camera or its covariance.
  std::optional<ProjectionDifference> difference;
  /// Excess of the camera's errors over the freed one's beyond what views share by chance, see
  /// misfitSigmas(); NaN without a freed camera.
  double misfit_sigmas = std::numeric_limits<double>::quiet_NaN();
  std::optional<DifferenceSignificance> significance;  ///< of the images' power to detect a difference
  double covered_share = 0;                            ///< of the image
  /// Test whether the images require any change of the camera; nothing if there are too few.
  std::optional<OverallTest> overall;
  /// One for each type of change that the views constrain, the most certain first.
  std::vector<NeededChange> changes;
  std::vector<Slip> slips;  ///< corrected, see mendedSlips(); none without a freed camera

  [[nodiscard]] int numCorners() const;  ///< those with an error
  [[nodiscard]] int numUnseen() const;
  /// RMS of all corners with the poses fitted to all of them, px, of the freed camera; NaN without one.
  [[nodiscard]] double freedRmsPx() const;
};

/// Judges a camera by views that it was not made from. The camera is never changed. Two questions are asked;
/// for the second, refitted poses cannot hide a wrong camera:
///
/// Does it predict corners? Each view's pose is found from one colour of the board's squares, and the error
/// is that of the other (heldOutErrors()).
///
/// Is it the camera that the images show? They are calibrated from scratch with the same model and the usual
/// procedure (robust loss, outliers, the boards' bends, covariance by the views if they disagree by more than
/// noise), and the projection difference between the two cameras is taken over the part of the image where
/// boards were. Tests of the unchanged camera (see HeldScores) show whether the difference is more than
/// chance: for all its parameters together, and for single changes.
///
/// Outliers of the freed calibration are excluded from both, and its board bends apply to both: none of this
/// depends on the tested camera.
///
/// @param boards  see calibrate()
/// @throws Error (kInput) for no views, or views of another image size than the camera's; Cancelled
[[nodiscard]] HeldOutJudgement judgeOnImages(const ComparedCamera& camera, std::span<const Board> boards,
                                             std::vector<View> views, const HeldOutOptions& options = {});
[[nodiscard]] HeldOutJudgement judgeOnImages(const ComparedCamera& camera, const Board& board,
                                             std::vector<View> views, const HeldOutOptions& options = {});

/// Findings from held-out images as checks: `held_out_error`, whether the camera predicts corners, and
/// `images_agree`, whether it is the camera that the images show. A camera fails if it is off by more than
/// chance and, according to the images, by more than the tolerance. If the images cannot decide, the result
/// is a warning.
[[nodiscard]] std::vector<Diagnosis> heldOutChecks(const HeldOutJudgement& judgement, double tolerance_px);

/// The slip that `images_agree` names; nothing if it names none.
[[nodiscard]] const Slip* namedSlip(const HeldOutJudgement& judgement, double tolerance_px);

/// The check `stated_accuracy`: whether the camera is as close to the one that the images show as its file
/// states. A note if the images cannot decide.
[[nodiscard]] Diagnosis statedAccuracyCheck(double accuracy_px, const HeldOutJudgement& judgement);

/// The check `against`: the difference to another camera, after the best rotation.
[[nodiscard]] Diagnosis againstCheck(const ComparedCamera& camera, const ComparedCamera& other,
                                     double tolerance_px);

/// The check `own_images`: whether the camera was calibrated from these images. An image counts as one of
/// them if the mean of its corners lies within 0.5 px of a recorded one.
/// @param recorded  see CalibrationRecord::view_centers
[[nodiscard]] Diagnosis ownImagesCheck(std::span<const Eigen::Vector2d> recorded,
                                       std::span<const View> views);

}  // namespace alidade
