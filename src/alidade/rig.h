// SPDX-License-Identifier: MIT
#pragma once

/// The main header of the component `rig`, which needs Ceres.
///
/// calibrate() estimates several cameras that are fixed to each other, and where they are, from boards that
/// they see at the same time. Its input is one RigViews per camera instead of views; images are matched by
/// name. Each camera of the result has a Calibration as a single camera does. recordOf() converts the result
/// to the record that saveRig() of alidade/files.h writes and loadRig() reads. Errors are thrown as
/// alidade::Error.
#include "alidade/core/error.h"
#include "alidade/record/rig_record.h"
#include "alidade/rig/rig_calibrator.h"
#include "alidade/rig/rig_validation.h"
