// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/adjust/board/fit.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"
#include "alidade/geometry/se3.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

// Data of the page of a rig, read from the evidence of its calibration. NaN: unknown.

struct ReportedRigCamera {
  std::string name;
  AnyCamera camera;
  ImageSize size;
  SE3 camera_from_rig = {};
  double rotation_std_rad = 0;  ///< norm of the standard deviations of the three coordinates
  double distance_std_m = 0;    ///< of the distance from the first camera
  double rms_px = 0;
  double alone_rms_px = 0;  ///< calibrated alone
  double transfer_px = 0;   ///< see RigCamera
  std::optional<Accuracy> accuracy = {};
};

/// A board in one frame.
struct ReportedPlacement {
  std::size_t frame = 0;
  std::size_t board = 0;  ///< index into ReportedRig::boards
  SE3 rig_from_board = {};
};

struct ReportedRig {
  Verdict verdict = Verdict::kNo;
  double tolerance_px = 1;
  double rms_px = 0;
  double holdout_rms_px = 0;
  int num_linked = 0;  ///< see RigLinks
  std::vector<ReportedRigCamera> cameras = {};
  std::vector<Board> boards = {};
  std::vector<std::string> frames = {};
  std::vector<ReportedPlacement> placements = {};
  std::vector<ReportedView> views = {};
  std::vector<Diagnosis> findings = {};
  RunOrigin origin = {};
};

/// Sum for a root mean square.
struct SquareSum {
  double sum = 0;
  std::size_t count = 0;

  [[nodiscard]] double rms() const { return count == 0 ? 0 : std::sqrt(sum / static_cast<double>(count)); }
};

/// Distances of corners from the epipolar lines of the same corners in a second camera.
struct EpipolarPair {
  std::size_t first = 0;  ///< cameras
  std::size_t second = 0;
  std::size_t num_corners = 0;
  double rms_px = 0;
  std::vector<std::pair<std::size_t, double>> by_frame = {};  ///< frame and RMS, px, in order of frames
};

/// A camera and what its images show, for figures that a single camera has, too; without boards and poses.
/// @pre the index of a camera
[[nodiscard]] CalibrationEvidence cameraData(const ReportedRig& rig, std::size_t camera);

/// True if a document is the evidence of a rig.
[[nodiscard]] bool isRigEvidence(const nlohmann::json& evidence);
/// @throws Error (kInput) naming the place of a missing value or one of the wrong kind
[[nodiscard]] ReportedRig readRig(const nlohmann::json& evidence, const std::string& file);
/// One entry for each two cameras that saw a corner at the same time. Distances are in pixels of the second
/// camera.
[[nodiscard]] std::vector<EpipolarPair> epipolarPairs(const ReportedRig& rig);

}  // namespace alidade
