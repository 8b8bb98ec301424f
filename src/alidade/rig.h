// SPDX-License-Identifier: MIT
#pragma once

/// The main header of the component `rig`, which needs Ceres.
///
/// calibrateRig() estimates several cameras that are fixed to each other, and where they are, from boards
/// that they see at the same time. Its input is one RigViews per camera; images are matched by name.
/// recordOf() converts the result to the record that rigFileText() of alidade/files.h writes and loadRig()
/// reads. Errors are thrown as alidade::Error.
#include "alidade/core/error.h"
#include "alidade/record/rig_record.h"
#include "alidade/rig/rig_calibrator.h"
#include "alidade/rig/rig_validation.h"
