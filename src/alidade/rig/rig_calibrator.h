// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "alidade/adjust/fit.h"
#include "alidade/calibrate/calibration.h"
#include "alidade/calibrate/start/options.h"
#include "alidade/core/diagnosis.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/record/rig_record.h"
#include "alidade/rig/rig_frames.h"
#include "alidade/target/board.h"

namespace alidade {

struct RigOptions {
  CalibratorOptions camera = {};         ///< of each camera
  std::vector<std::string> models = {};  ///< one per camera instead of CalibratorOptions::model; or none
};

/// A camera of a calibrated rig.
struct RigCamera {
  std::string name;
  Calibration alone;  ///< from its own views alone
  double rms_px = 0;  ///< in the joint fit
  double alone_rms_px = 0;
  /// The error with which a pixel of the camera that shares most boards with this one, at the distance of the
  /// boards, becomes a pixel of this one: 95 % of the errors are smaller, px. NaN if it is unknown.
  double transfer_px = 0;
  Eigen::Vector3d position_std_m = Eigen::Vector3d::Zero();  ///< of the rig's origin in the camera frame
  Eigen::Vector3d rotation_std_rad = Eigen::Vector3d::Zero();
};

/// A view that contradicts the others of its frame.
struct UnlinkedView {
  std::size_t camera = 0;
  std::string image;
  std::string frame;
};

/// Several cameras, calibrated together.
struct RigCalibration {
  std::vector<RigCamera> cameras;
  /// Of all cameras; the first one is at the rig's origin. Corners of ambiguous boards are numbered alike in
  /// all views of a frame. Weights are inverse variances, px^-2.
  Fit fit;
  std::vector<std::string> frames;  ///< names, by FitPlacement::frame
  std::size_t num_linked = 0;       ///< placements of boards that two or more cameras saw
  std::size_t num_renumbered = 0;   ///< views of ambiguous boards that were numbered otherwise
  std::vector<UnlinkedView> unlinked;
  /// The covariance to use, with the columns of rigColumns(); empty if the frames do not determine the rig.
  DenseMatrix covariance;
  bool is_by_frames = false;         ///< it is by the frames, which disagree by more than noise explains
  std::vector<Diagnosis> diagnoses;  ///< of the rig and of its cameras, failures first

  [[nodiscard]] Verdict verdict() const { return verdictOf(diagnoses); }
  [[nodiscard]] bool isUsable() const { return verdict() != Verdict::kNo; }
};

/// Where the unknowns of a rig stand in its covariance: the parameters of each camera, then camera_from_rig
/// of each but the first (SE3's tangent), then the bends of the boards whose shape is free.
struct RigColumns {
  std::vector<int> params;  ///< first column of each camera's parameters
  std::vector<int> pose;    ///< of each camera's pose; -1 for the first camera
  std::vector<int> bend;    ///< of each board's bends; -1 for a fixed shape
  int count = 0;
};
[[nodiscard]] RigColumns rigColumns(const Fit& fit);

/// Calibrates each camera alone, links them by boards that two of them see at the same time, and solves all
/// intrinsics, poses and board shapes together. Cameras need not see the same board; two that never do are
/// linked through others. Views of boards that look the same after a turn are numbered alike. A view that
/// contradicts the others of its frame keeps a pose of its own.
/// @param cameras  two or more, in the order of the result; frames are matched by the images' names
/// @throws Error as calibrate(), with the camera's name; Error (kInput) for cameras that nothing links
[[nodiscard]] RigCalibration calibrateRig(std::span<const Board> boards, std::vector<RigViews> cameras,
                                          const RigOptions& options = {});

/// What a rig file contains. The cameras have their parameters and covariance from the joint fit; their
/// verdict and accuracy are those of their own views.
[[nodiscard]] RigRecord recordOf(const RigCalibration& rig, const std::string& created_by);

}  // namespace alidade
