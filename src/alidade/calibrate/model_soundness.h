// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "alidade/calibrate/bundle_adjustment.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"

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
[[nodiscard]] std::optional<Unsoundness> unsoundnessOf(std::string_view model_id, ImageSize size,
                                                       std::span<const std::vector<Observation>> views,
                                                       const BundleState& state, const BundleSummary& summary,
                                                       const ParamConstraint& constraint);

}  // namespace alidade
