// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/imagery/output_view.h"

namespace alidade {

/// Describes an image without distortion in a projection that no camera file describes. Rays of pixels all
/// over the image serve as a self check, and every number has the fewest digits that read back as the same
/// double. @throws std::logic_error for a rectilinear view, or unequal scales
[[nodiscard]] std::string projectionFileText(const OutputView& view, const std::string& created_by);

}  // namespace alidade
