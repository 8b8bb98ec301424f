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
#include "alidade/target/view.h"
#include "alidade/validate/held_out/held_scores.h"

namespace alidade {

struct HeldOutOptions {
  /// The tested camera's covariance takes only views for independent; otherwise it is that by noise alone.
  bool is_covariance_by_views = false;
  int jobs = 1;  ///< threads, 0: one per processor; the answer is the same bit by bit
  const CancelFlag* cancel = nullptr;
};

/// A corner that had no part in the pose by which it is predicted.
struct HeldOutCorner {
  int id = 0;
  Eigen::Vector2d pixel{0, 0};     ///< where it was seen
  Eigen::Vector2d error_px{0, 0};  ///< projected minus observed
};

/// A view of the board, as the camera that is tested sees it.
struct HeldOutView {
  std::string image;
  std::size_t board = 0;    ///< see View
  bool is_testable = true;  ///< see isTestable()
  int num_corners = 0;      ///< with an error
  int num_unseen = 0;       ///< that the camera cannot see from the pose of the others
  double rms_px = std::numeric_limits<double>::quiet_NaN();
  /// RMS of all corners with the pose fitted to all of them, px: of the camera as it is, and of the freed
  /// one.
  double fixed_rms_px = std::numeric_limits<double>::quiet_NaN();
  double freed_rms_px = std::numeric_limits<double>::quiet_NaN();
  SE3 camera_from_board = {};               ///< fitted to all corners, for the camera as it is
  std::vector<HeldOutCorner> corners = {};  ///< with an error, in ascending order of id
};

/// A change of one number that the images ask for.
struct NeededChange {
  CameraChangeKind change;
  StepEstimate estimate;
  /// The projection difference that the change makes where the boards were, the rotation taken out: 95 %;
  /// infinity where it makes a camera that cannot be, or cannot be compared. NaN if it is not even a hint.
  double p95_px = std::numeric_limits<double>::quiet_NaN();
  /// The change brought to rest, where it is a hint: `estimate` is only its first step. Nothing where that
  /// does not succeed.
  std::optional<StepEstimate> refined = std::nullopt;

  /// Whether it is worth mentioning: beyond two standard deviations.
  [[nodiscard]] bool isHint() const { return estimate.sigmas > 2; }
};

/// The result of a test on images that the camera was not made from.
struct HeldOutJudgement {
  int num_views_given = 0;
  std::vector<HeldOutView> views;  ///< those used, in order of image name
  /// sqrt(mean of dx^2 + dy^2) over corners that had no part in their view's pose, px. NaN if there are none.
  double held_out_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// One standard deviation an axis of the noise by which neighbouring corners differ, of the camera as it is
  /// or of the freed one, whose errors differ less: a camera that is far off is no measure of noise. NaN
  /// without neighbours.
  double noise_sigma_px = std::numeric_limits<double>::quiet_NaN();
  /// held_out_rms_px for that noise alone.
  double noise_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// The camera of the same model that these images give by themselves; nothing where they give none.
  std::optional<Calibration> freed;
  std::string freed_complaint;  ///< why there is none
  /// RMS of all corners with the poses fitted to all of them, px, of the camera as it is.
  double fixed_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// From the camera to the freed one, the rotation taken out, where the boards were: nothing without a freed
  /// one, or without a covariance of it.
  std::optional<ProjectionDifference> difference;
  /// How far beyond what the views share by chance the camera's errors exceed the freed one's, see
  /// misfitSigmas(); NaN without a freed one.
  double misfit_sigmas = std::numeric_limits<double>::quiet_NaN();
  std::optional<DifferenceSignificance> significance;  ///< for what the images would notice
  double covered_share = 0;                            ///< of the image
  /// Whether the images ask for a different camera at all; nothing where they are too few to tell.
  std::optional<OverallTest> overall;
  /// One for each way to change the camera that the views say something of, the surest first.
  std::vector<NeededChange> changes;
  std::vector<Slip> slips;  ///< mended, see mendedSlips(); none without a freed camera

  [[nodiscard]] int numCorners() const;  ///< with an error
  [[nodiscard]] int numUnseen() const;
  /// RMS of all corners with the poses fitted to all of them, px, of the freed camera; NaN without one.
  [[nodiscard]] double freedRmsPx() const;
};

/// Judges a camera by views that it was not made from. The camera is held as it is throughout; two questions
/// are asked, of which the second is the one that refitted poses cannot hide a wrong camera from:
///
/// Does it predict corners? Each view's pose is found from one colour of the board's squares, and the error
/// is that of the other (heldOutErrors()).
///
/// Is it the camera that the images show? They are calibrated from scratch with the same model, with
/// everything that goes with it (robust loss, outliers, the boards' bends, covariance by the views where they
/// disagree by more than noise), and the projection difference between the two cameras is taken over the part
/// of the image where boards were. Whether that difference is more than chance is asked of the camera as it
/// is (see HeldScores): of all its parameters together, and of single changes.
///
/// Corners that the freed calibration took for outliers count for neither, and its bends of the boards hold
/// for both: none of that depends on the camera that is tested.
///
/// @param boards  see calibrate()
/// @throws Error (kInput) for no views, or views of another image size than the camera's; Cancelled
[[nodiscard]] HeldOutJudgement judgeOnImages(const ComparedCamera& camera, std::span<const Board> boards,
                                             std::vector<View> views, const HeldOutOptions& options = {});
[[nodiscard]] HeldOutJudgement judgeOnImages(const ComparedCamera& camera, const Board& board,
                                             std::vector<View> views, const HeldOutOptions& options = {});

/// By how much a camera may be off before it is called wrong, px: see docs/comparing.md for where it comes
/// from.
inline constexpr double kDefaultTolerancePx = 0.2;

/// What held-out images say as checks: `held_out_error`, whether the camera predicts corners, and
/// `images_agree`, whether it is the camera that the images show. A camera fails where it is off by more than
/// chance and, as far as the images tell, by more than the tolerance; where they cannot tell, that is a
/// warning.
[[nodiscard]] std::vector<Diagnosis> heldOutChecks(const HeldOutJudgement& judgement, double tolerance_px);

/// The slip that `images_agree` names; nothing if it names none.
[[nodiscard]] const Slip* namedSlip(const HeldOutJudgement& judgement, double tolerance_px);

/// The check `stated_accuracy`: whether the camera is as near to the one that the images show as its file
/// states. A note where the images cannot tell.
[[nodiscard]] Diagnosis statedAccuracyCheck(double accuracy_px, const HeldOutJudgement& judgement);

/// The check `against`: the difference to another camera, the rotation taken out.
[[nodiscard]] Diagnosis againstCheck(const ComparedCamera& camera, const ComparedCamera& other,
                                     double tolerance_px);

/// The check `own_images`: whether the camera was calibrated from these images. It is assumed of an image
/// whose mean of the corners lies within 0.5 px of a recorded one.
/// @param recorded  see CalibrationRecord::view_centers
[[nodiscard]] Diagnosis ownImagesCheck(std::span<const Eigen::Vector2d> recorded,
                                       std::span<const View> views);

}  // namespace alidade
