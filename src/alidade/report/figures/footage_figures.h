// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/validate/footage/footage_judgement.h"

namespace alidade {

// Figures and texts on footage for a validation page.

/// Errors in each part of the image, of pixels not used for their own points. Cells carry their RMS and the
/// number of pixels as data-rms and data-count. Nothing if no camera could be tested.
[[nodiscard]] std::optional<Figure> footageErrorsFigure(const FootageJudgement& footage);

/// The camera changes that were tried, with the displacement by each, as HTML: one table, or one for each
/// edit that may explain a different image size.
/// @param prefix  of ids, for a page with several cameras
[[nodiscard]] std::string footageTables(const FootageJudgement& footage, const std::string& prefix);

/// "consistent", "inconsistent", "cannot tell".
[[nodiscard]] std::string footageVerdictWords(FootageVerdict verdict);

/// The result of the check, as a sentence; empty without that check.
[[nodiscard]] std::string footageSentence(const std::vector<Diagnosis>& checks);

}  // namespace alidade
