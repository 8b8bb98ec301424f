// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/footage/check/camera_check.h"
#include "alidade/record/camera_record.h"
#include "alidade/validate/footage/footage_judgement.h"

namespace alidade {

/// The verdict of footage on a camera file, as checks: `footage` (a failure if it is inconsistent, a warning
/// if footage cannot decide), and notes: `footage_fit` (a different camera fits better, but not
/// significantly) and `footage_shutter` (a rolling shutter).
/// @param file  the camera file's name, for commands
[[nodiscard]] std::vector<Diagnosis> footageFindings(const FootageJudgement& judgement,
                                                     const CameraRecord& camera, const std::string& file);

/// Reason why footage cannot decide, and what to film instead: "no parallax; film while moving sideways past
/// near and far things".
[[nodiscard]] std::string gapWords(const FootageJudgement& judgement);

/// The likely cause of a change, in plain words, and what to do.
/// @param file  the camera as stated in the file
[[nodiscard]] std::string likelyCause(const CameraChange& change, const AnyCamera& file);

}  // namespace alidade
