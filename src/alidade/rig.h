// SPDX-License-Identifier: MIT
#pragma once

/// The main header of the component `rig`, which needs Ceres.
///
/// calibrate() estimates several cameras that are fixed to each other, and where they are, from boards that
/// they see at the same time. Its input is one RigViews per camera instead of views; images are matched by
/// name. Each camera of the result has a Calibration as a single camera does. recordOf() converts the result
/// to the record that saveRig() of alidade/files.h writes and loadRig() reads. Errors are thrown as
/// alidade::Error.
///
///     const alidade::Board board = alidade::Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025};
///     std::vector<alidade::RigViews> cameras(2);  // with the views of each
///     cameras[0].name = "left";
///     cameras[1].name = "right";
///     const alidade::RigCalibration rig = alidade::calibrate(board, cameras);
///     for (const alidade::Diagnosis& diagnosis : rig.diagnoses) std::puts(diagnosis.message().c_str());
///     const Eigen::Vector3d shift = rig.fit.cameras[1].camera_from_rig.translation;
///     std::printf("%.1f mm apart\n", 1e3 * shift.norm());
///     const alidade::RigRecord record = alidade::recordOf(rig, "my program");
#include "alidade/core/error.h"
#include "alidade/record/rig_record.h"
#include "alidade/rig/rig_calibrator.h"
#include "alidade/rig/rig_validation.h"
