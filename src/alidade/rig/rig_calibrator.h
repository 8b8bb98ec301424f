// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/record/camera_record.h"
#include "alidade/record/rig_record.h"
#include "alidade/rig/rig_calibration.h"
#include "alidade/target/board.h"
#include "alidade/target/frame_table.h"

namespace alidade {

struct RigOptions {
  CalibratorOptions camera = {};         ///< of each camera
  std::vector<std::string> models = {};  ///< one per camera instead of CalibratorOptions::model; or empty
  std::vector<std::optional<std::size_t>> num_pupil = {};  ///< the same for CalibratorOptions::num_pupil
  /// One per camera, or empty: cameras calibrated before, whose lenses are kept.
  std::vector<std::optional<CameraRecord>> given = {};
  FrameTable frames = {};         ///< images taken together; empty: matched by their names
  bool are_simultaneous = false;  ///< images of one frame were taken at one instant; times are not estimated
  double rate_hz = 0;             ///< of images whose names count them, such as frames of videos; 0: unknown
};

/// Calibrates each camera alone, links cameras by boards that two of them see at the same time, and solves
/// all intrinsics, poses and board shapes together. Cameras need not see the same board; two that never share
/// one are linked through others. Views of boards that look the same after a turn are numbered consistently.
/// A view that contradicts the others of its frame keeps its own pose. Frames between which a board did not
/// move count as one frame for this board. Given lenses are compared with those of a second calibration that
/// frees them.
/// @param cameras  two or more, in the order of the result
/// @throws Error as calibrate(), with the camera's name; Error (kInput) for cameras that nothing links, and
/// for images that cannot be matched
[[nodiscard]] RigCalibration calibrate(std::span<const Board> boards, std::vector<RigViews> cameras,
                                       const RigOptions& options = {});
[[nodiscard]] RigCalibration calibrate(const Board& board, std::vector<RigViews> cameras,
                                       const RigOptions& options = {});

/// The number of frames with a board that two or more cameras saw.
[[nodiscard]] int numLinkedFrames(const RigCalibration& rig);

/// Content of a rig file. The cameras have parameters, covariance, verdict and accuracy of the joint fit. A
/// given camera is stored as given.
[[nodiscard]] RigRecord recordOf(const RigCalibration& rig, const std::string& created_by);

}  // namespace alidade
