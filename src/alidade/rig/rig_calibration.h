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

/// How the images of a camera contradict the lens that was given for it.
struct LensMisfit {
  double effect_px = 0;  ///< between the given lens and the freed one: within it for 95 % of the corners
  double freed_rms_px = 0;
};

/// How a camera hangs together with the others of its rig, and how well its pose is known. NaN if the frames
/// do not determine the rig.
struct CameraLink {
  std::size_t num_views = 0;    ///< of boards that another camera saw at the same time
  std::size_t num_grazing = 0;  ///< of these: with the board turned by more than kGrazingRad
  std::size_t partner = 0;      ///< the camera that shares most boards with this one
  /// The error with which a pixel of the partner, at the distance of the boards, becomes a pixel of this
  /// camera: 95 % of the errors are smaller, px.
  double transfer_px = std::numeric_limits<double>::quiet_NaN();
  /// Standard deviations of the tangent [v, w] of camera_from_rig Exp([v, w]), in the rig's frame. Those of
  /// the first camera are 0, as it is at the origin.
  Eigen::Vector3d translation_std_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d rotation_std_rad = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d position_std_m =  ///< of the camera's centre in the rig's frame
      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  double distance_std_m =
      std::numeric_limits<double>::quiet_NaN();  ///< of its distance from the first camera
};

/// A camera of a calibrated rig.
struct RigCamera {
  std::string name;
  std::optional<CameraRecord> given = {};  ///< whose lens was kept; empty: calibrated
  std::optional<LensMisfit> misfit = {};   ///< of the given lens
  /// As the joint fit has it, see jointCamera(): the one to use.
  Calibration calibration = {};
  Calibration alone = {};  ///< from its own views alone: where the joint fit began
  double rms_px = 0;       ///< in the joint fit
  double alone_rms_px = 0;
  CameraLink link = {};
};

/// The angle between the line of sight and a board's normal from which a view is grazing.
inline constexpr double kGrazingRad = 1.134;  // 65 degrees

/// A camera that stands elsewhere from some frame on.
struct CameraMotion {
  std::size_t camera = 0;
  std::string from_frame;     ///< the first frame after the motion
  SE3 after_from_before;      ///< of camera frames
  double effect_px = 0;       ///< by which points at the boards' distance move, median
  std::size_t num_after = 0;  ///< views after it
};

/// The covariance of a rig's unknowns.
struct RigCovariance {
  DenseMatrix matrix =
      {};  ///< with the columns of jointColumns(); empty if the frames do not determine the rig
  bool is_by_frames = false;  ///< it is by the frames, which disagree by more than noise explains
  /// Of a corner's coordinate, weights being inverse variances: 1, or more where frames disagree.
  double frame_variance = 1;

  [[nodiscard]] bool isKnown() const { return matrix.rows() > 0; }
};

/// How the views of a rig are linked by boards that several cameras saw in one frame.
struct RigLinks {
  std::size_t num_linked = 0;           ///< placements of boards that two or more cameras saw
  std::size_t num_common_views = 0;     ///< views of boards that another camera saw in the same frame
  std::size_t num_lone_views = 0;       ///< of these, those that are linked with no other
  std::size_t num_renumbered = 0;       ///< views of ambiguous boards that were numbered otherwise
  std::vector<RigImage> unlinked = {};  ///< views that contradict the others of their frame
};

/// Several cameras, calibrated together.
struct RigCalibration {
  std::vector<RigCamera> cameras = {};
  /// Of all cameras; the first one is at the rig's origin. Corners of ambiguous boards are numbered alike in
  /// all views of a frame. Weights are inverse variances, px^-2.
  Fit fit = {};
  RigFrames frames = {};  ///< names by FitPlacement::frame
  RigLinks links = {};
  RigCovariance covariance = {};
  bool are_points_lost =
      false;  ///< a board is uneven for a camera alone, but no places of its points fit all
  bool are_lenses_tested = true;  ///< given lenses were compared with freed ones, see RigCamera::misfit
  std::vector<CameraMotion> motions = {};  ///< largest effect first
  HoldoutReport holdout = {};              ///< see rigHoldout()
  std::vector<Diagnosis> diagnoses = {};   ///< of the rig and of its cameras, failures first

  [[nodiscard]] Verdict verdict() const { return verdictOf(diagnoses); }
  [[nodiscard]] bool isUsable() const { return verdict() != Verdict::kNo; }
};

}  // namespace alidade
