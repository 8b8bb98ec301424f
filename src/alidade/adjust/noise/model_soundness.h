// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "alidade/adjust/board/fit.h"
#include "alidade/camera/any_camera.h"

namespace alidade {

/// The reason why a camera must not be recommended.
struct Unsoundness {
  std::string id;    ///< stable: "ill_conditioned"
  std::string text;  ///< for people
  /// The parameters are determined and fit the corners, but the lens is unusable outside the area of the
  /// corners.
  bool folds = false;
};

/// Checks a solution of a model: the views determine it, it sees all of their corners, and it does not fold
/// inside the image. Nothing if all is well.
/// @param fit  of one camera, as returned by solve()
[[nodiscard]] std::optional<Unsoundness> unsoundnessOf(const Fit& fit);

/// Number of corners in use that `camera`, the only camera of the fit, cannot see by its own domain.
[[nodiscard]] std::size_t numCornersOutside(const Fit& fit, const AnyCamera& camera);

}  // namespace alidade
