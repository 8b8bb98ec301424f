// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/core/cancel.h"
#include "alidade/core/diagnosis.h"
#include "alidade/record/camera_record.h"
#include "alidade/rig/joint_fit.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

// Stages of the calibration of a rig after the joint fit.

/// The covariance of a solved rig: by corner noise, or by frames if these disagree by more than noise.
/// @param given  the cameras whose lenses were kept, or nothing for each that was calibrated; may be empty
/// @param alone  the cameras' own calibrations, which show errors of the boards' print
[[nodiscard]] RigCovariance rigCovariance(const Fit& fit, std::span<const std::optional<CameraRecord>> given,
                                          std::span<const Calibration> alone);

/// The links of each camera of a solved rig, and the accuracy of its pose.
[[nodiscard]] std::vector<CameraLink> cameraLinks(const Fit& fit, const RigCovariance& covariance);

/// The vector from the centre of one camera of a rig to that of another, in the rig's frame.
struct Baseline {
  Eigen::Vector3d vector_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  [[nodiscard]] double lengthStd() const;  ///< standard deviation of its length, m
};
/// @param covariance  known
[[nodiscard]] Baseline baselineOf(const Fit& fit, const RigCovariance& covariance, std::size_t from,
                                  std::size_t to);

/// Finds cameras whose pose changes at some frame. Frames are in the order of their names. Two cases:
///
/// - A motion larger than the noise unlinks all of the camera's views before or after it. These agree on a
/// different pose.
/// - A smaller motion leaves the views linked. For each camera and each frame, a score test compares one pose
/// of the camera with two, with all unknowns of the rig free (Rao 1948).
///
/// @param covariance  of `joint`
[[nodiscard]] std::vector<CameraMotion> cameraMotions(const JointViews& views, const JointFit& joint,
                                                      const RigCovariance& covariance);

/// Cross-validation over frames. Each fold of frames is left out in turn, and cameras and their poses are
/// estimated from the others. Each board of a left-out frame then gets a pose from half of the corners of all
/// cameras that see it, and errors on the other half, and vice versa. Board shapes are not estimated again.
/// num_folds is 0 if the other frames do not determine the rig.
[[nodiscard]] HoldoutReport rigHoldout(const Fit& fit, const CancelFlag* cancel);

/// One camera of a solved rig as the joint fit has it: lens, poses, boards and errors, the covariance from
/// all cameras, and the resulting accuracy and diagnoses. Choice, dropped corners and tests of its own views
/// remain those of the camera alone.
/// @param alone       the camera's own calibration
/// @param covariance  of the rig; without it only the fit and what follows from it come from the joint fit
[[nodiscard]] Calibration jointCamera(Calibration alone, const Fit& rig, const RigCovariance& covariance,
                                      std::size_t camera, double tolerance_px, double distance_m);

/// Compares a given lens with the one from a rig's images, at their corners.
/// @param rig  with all lenses freed
/// @returns nothing if the two differ by no more than their covariances explain
[[nodiscard]] std::optional<LensMisfit> givenLensMisfit(const CameraRecord& given, const RigCalibration& rig,
                                                        std::size_t camera);

/// The largest error in the images of a camera that its lens or its own diagnoses state (95 %), px.
[[nodiscard]] double foundErrorPx(const RigCamera& camera);

/// Judges everything in a rig except `diagnoses`, and repeats the diagnoses of its cameras' own calibrations;
/// failures first.
[[nodiscard]] std::vector<Diagnosis> judgeRig(const RigCalibration& rig, double tolerance_px);

}  // namespace alidade
