// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/camera/projection_uncertainty.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// A grid as the camera file has it, with four digits: more would be read by nobody. Nothing if no pixel has
/// a ray, or a sigma is not finite.
[[nodiscard]] std::optional<ProjectionStdRecord> projectionRecord(const UncertaintyGrid& grid);

}  // namespace alidade
