// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// Parameters with which the model `model_id` is exactly the same lens as `camera`, where algebra knows them;
/// nothing otherwise. The known relations:
///
///   pinhole, radtan, rational, thin_prism, tilted  each is the one before with more terms; both ways, as
///   long
///                                          as the terms that the other does not have are zero
///   brown beside rational; kannala_brandt before kannala_brandt_skew, thin_prism_fisheye and fisheye624;
///   pinhole before inverse_brown and division, division before ocam: in the same way
///   ucm = omni without distortion          xi = alpha / (1 - alpha), fx and fy times 1 + xi
///   ucm = eucm with beta 1 = double_sphere with xi 0
///   ucm, eucm with alpha 0 = fov with w 0 = pinhole
///   omni with xi 0 = radtan with k3 0
///
/// and chains of these. Two models may still end at different field angles.
/// @throws Error (kUsage) for an unknown id
[[nodiscard]] std::optional<std::vector<double>> sameLensParameters(const AnyCamera& camera,
                                                                    std::string_view model_id);

/// The parameters that `model_id` shares with the camera's model, by name; its other parameters are zero.
/// This is the same camera if one model contains the other.
[[nodiscard]] std::vector<double> parametersByName(std::string_view from_id, std::span<const double> params,
                                                   std::string_view model_id);

/// The same lens in `model_id` if it has it, otherwise what the models share by name.
[[nodiscard]] std::vector<double> closestByName(const AnyCamera& like, std::string_view model_id);

}  // namespace alidade
