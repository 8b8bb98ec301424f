// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/calibrate/calibration.h"
#include "alidade/calibrate/start/options.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// Calibrates one camera from views of one board or of several; an initial guess is not needed. An image may
/// show several boards: each is a view of its own, with the index of its board in View::board. The views are
/// sorted by image name and board first, so the result does not depend on their order. Corners that state
/// different sigmas are weighted (CornerNoise).
/// @throws Error (kInput) for fewer than kMinViews views, views without a name or size, views of different
/// image sizes, two views of one board in one image, a board index that does not exist, corner ids that the
/// board does not have or that occur twice in a view, corners that are not finite, negative sigmas, views
/// that no camera explains, or an initial camera of another image size; Error (kUsage) for a board without
/// rows, columns or square size, an unknown model, an unknown fixed parameter, or a fixed parameter without a
/// value; Cancelled. A poor result does not throw: see Calibration::diagnoses. Views that cannot be used are
/// left out: see Calibration::dropped.
[[nodiscard]] Calibration calibrate(std::span<const Board> boards, std::vector<View> views,
                                    const CalibratorOptions& options = {});
[[nodiscard]] Calibration calibrate(const Board& board, std::vector<View> views,
                                    const CalibratorOptions& options = {});

}  // namespace alidade
