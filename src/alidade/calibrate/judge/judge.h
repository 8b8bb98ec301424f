// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/judge/evidence.h"

namespace alidade::detail {

/// All problems found with a calibration, failures first; pure judgement, no estimation.
///
/// A failure makes the answer wrong or meaningless whatever the tolerance. Every other diagnosis states its
/// effect in pixels, from which its severity follows by severityOf().
[[nodiscard]] std::vector<Diagnosis> judge(const Evidence& evidence);

}  // namespace alidade::detail
