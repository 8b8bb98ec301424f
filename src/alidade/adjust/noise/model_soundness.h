// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "alidade/adjust/board/fit.h"
#include "alidade/camera/any_camera.h"

namespace alidade {

/// Why a camera must not be recommended.
struct Unsoundness {
  std::string id;    ///< stable: "ill_conditioned"
  std::string text;  ///< for people
  /// The parameters are determined and fit the corners, but the lens is not to be used beyond these.
  bool folds = false;
};

/// Looks at a solution of a model: do these views determine it, does it see all of their corners, and does it
/// not fold inside the image? Nothing if all is well.
/// @param fit  of one camera, as solve() left it
[[nodiscard]] std::optional<Unsoundness> unsoundnessOf(const Fit& fit);

/// Corners in use of a fit of one camera that this camera, which is `camera`, says that it cannot see.
[[nodiscard]] std::size_t numCornersOutside(const Fit& fit, const AnyCamera& camera);

}  // namespace alidade
