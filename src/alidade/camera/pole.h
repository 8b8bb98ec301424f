// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// The field angle of the first pole of the lens, rad, at which its projection goes to infinity; nothing if
/// it has none.
[[nodiscard]] std::optional<double> poleAngle(const AnyCamera& camera);

}  // namespace alidade
