// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/core/diagnosis.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/record/camera_record.h"
#include "alidade/rig/rig_frames.h"

namespace alidade {

/// Contradiction between the images of a camera and its given lens.
struct LensMisfit {
  double effect_px = 0;  ///< difference between given and freed lens that 95 % of the corners do not exceed
  double sure_px = 0;    ///< the part of it that chance does not explain
  double freed_rms_px = 0;
};

/// Links of a camera with the others of its rig, and the accuracy of its pose. NaN if the frames do not
/// determine the rig.
struct CameraLink {
  std::size_t num_views = 0;    ///< of boards that a second camera saw at the same time
  std::size_t num_grazing = 0;  ///< of these, with the board turned by more than kGrazingRad
  std::size_t partner = 0;      ///< the camera that shares the most boards with this one
  bool is_by_motion = false;    ///< the two never see the same board in one frame
  /// Error of transferring a pixel from the partner to this camera at the distance of the boards: 95 % of the
  /// errors are smaller, px. By the covariance, and the largest error that either camera's diagnoses state.
  double transfer_px = std::numeric_limits<double>::quiet_NaN();
  /// Standard deviations of the tangent [v, w] of camera_from_rig Exp([v, w]), in the rig's frame. Zero for
  /// the first camera, which is at the origin.
  Eigen::Vector3d translation_std_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d rotation_std_rad = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d position_std_m =  ///< of the camera's centre in the rig's frame
      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  double distance_std_m =
      std::numeric_limits<double>::quiet_NaN();  ///< of its distance from the first camera
  double delay_std_intervals = 0;                ///< of FitCamera::delay; 0 for a fixed one
};

/// A camera of a calibrated rig.
struct RigCamera {
  std::string name;
  std::optional<CameraRecord> given = {};  ///< record with the lens that was kept; empty: calibrated
  std::optional<LensMisfit> misfit = {};   ///< of the given lens
  /// Result of the joint fit, see jointCamera(); use this one.
  Calibration calibration = {};
  Calibration alone = {};  ///< from its own views alone, the start of the joint fit
  double rms_px = 0;       ///< in the joint fit
  double alone_rms_px = 0;
  CameraLink link = {};
};

/// Angle between the line of sight and a board's normal beyond which a view is grazing.
inline constexpr double kGrazingRad = 1.134;  // 65 degrees

/// A camera whose pose changes at some frame.
struct CameraMotion {
  std::size_t camera = 0;
  std::string from_frame;     ///< the first frame after the motion
  SE3 after_from_before;      ///< of camera frames
  double effect_px = 0;       ///< median displacement of points at the boards' distance
  std::size_t num_after = 0;  ///< views after it
};

/// The covariance of a rig's unknowns.
struct RigCovariance {
  DenseMatrix matrix =
      {};  ///< with the columns of jointColumns(); empty if the frames do not determine the rig
  bool is_by_frames = false;  ///< by frames, which disagree by more than noise explains
  /// The covariance with the given lenses taken as exact.
  DenseMatrix of_images = {};
  /// Derivatives of the estimates by the parameters of all given lenses, in the order of the cameras.
  DenseMatrix by_given = {};
  double size_std = 0;  ///< of the boards, as a share of it; part of the matrix
  /// Variance of a corner's coordinate if weights are inverse variances: 1, or more if frames disagree.
  double frame_variance = 1;

  [[nodiscard]] bool isKnown() const { return matrix.rows() > 0; }
};

/// Turns of the bodies before a rig between all pairs of frames.
struct RigTurns {
  Eigen::Vector3d main_axis = Eigen::Vector3d::Zero();  ///< of most of them, in a camera's frame
  double main_rad = 0;                                  ///< RMS about it
  double second_rad = 0;                                ///< about the axis that comes next
};

/// Links between the views of a rig by boards that several cameras saw in one frame.
struct RigLinks {
  std::size_t num_linked = 0;           ///< placements of bodies that two or more cameras saw
  std::size_t num_common_views = 0;     ///< views of boards that a second camera saw in the same frame
  std::size_t num_lone_views = 0;       ///< of these, views that are linked with no other
  std::size_t num_renumbered = 0;       ///< views of ambiguous boards that were renumbered
  std::vector<RigImage> unlinked = {};  ///< views that contradict the others of their frame
  /// The part of each camera by common boards, if some parts are linked by motion, see linkByMotion().
  std::vector<std::size_t> common_part_of = {};
  RigTurns turns = {};
};

/// Scatter of the times at which the cameras of a rig take the images of one frame.
struct ExposureScatter {
  double std_intervals = 0;  ///< standard deviation, in intervals between frames
  double shift_m = 0;        ///< RMS displacement of the middle of the boards by it and by the delays
  double shift_px = 0;       ///< RMS displacement of their corners in the images
};

/// Several cameras, calibrated together.
struct RigCalibration {
  std::vector<RigCamera> cameras = {};
  /// Fit of all cameras; the first one is at the rig's origin. Corners of ambiguous boards are numbered
  /// consistently in all views of a frame. Weights are inverse variances, px^-2.
  Fit fit = {};
  RigFrames frames = {};  ///< names by FitPlacement::frame
  RigLinks links = {};
  RigCovariance covariance = {};
  std::optional<ExposureScatter> exposure = {};  ///< if images of a frame were not taken at one instant
  bool are_points_lost = false;   ///< a board is uneven for a camera alone, but no point positions fit all
  bool are_lenses_tested = true;  ///< given lenses were compared with freed ones, see RigCamera::misfit
  std::vector<CameraMotion> motions = {};  ///< largest effect first
  HoldoutReport holdout = {};              ///< see rigHoldout()
  std::vector<Diagnosis> diagnoses = {};   ///< on the rig and its cameras, failures first

  [[nodiscard]] Verdict verdict() const { return verdictOf(diagnoses); }
  [[nodiscard]] bool isUsable() const { return verdict() != Verdict::kNo; }
};

}  // namespace alidade
