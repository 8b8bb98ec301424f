// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// Parameters with which the model `model_id` is exactly the same lens as `camera`, where algebra knows them;
/// nothing otherwise. The known relations:
///
///   pinhole, radtan, rational, thin_prism  each is the one before with more terms; both ways, as long as
///                                          the terms that the other does not have are zero
///   ucm = omni without distortion          xi = alpha / (1 - alpha), fx and fy times 1 + xi
///   ucm = eucm with beta 1 = double_sphere with xi 0
///   ucm, eucm with alpha 0 = fov with w 0 = pinhole
///   omni with xi 0 = radtan with k3 0
///
/// and chains of these. Two models may still end at different field angles.
/// @throws Error (kUsage) for an unknown id
[[nodiscard]] std::optional<std::vector<double>> sameLensParameters(const AnyCamera& camera,
                                                                    std::string_view model_id);

}  // namespace alidade
