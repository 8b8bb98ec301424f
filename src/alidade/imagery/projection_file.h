// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/imagery/output_view.h"

namespace alidade {

/// What an image without distortion shows, as a file for the projections that no camera file describes: with
/// rays of pixels all over the image as a self check, and every number in the fewest digits that read back as
/// the same double. @throws std::logic_error for a rectilinear view, or unequal scales
[[nodiscard]] std::string projectionFileText(const OutputView& view, const std::string& created_by);

}  // namespace alidade
