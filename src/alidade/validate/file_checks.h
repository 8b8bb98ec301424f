// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/validate/camera_checks.h"

namespace alidade {

/// How a file states its camera.
struct FileClaims {
  const AnyCamera* camera = nullptr;
  std::optional<ImageSize> image_size;  ///< nothing: the file does not say
  /// By how much the text of each parameter may be rounded, in parameter order; empty = unknown.
  std::span<const double> half_units;
  std::vector<std::string> unknown_keys;  ///< a sentence each
  std::vector<std::string> assumed;       ///< what was taken for granted, a sentence each
  /// What the file says beside the camera and nothing here goes by, a sentence each.
  std::vector<std::string> not_carried = {};
};

/// The size to check a camera by that has none: its principal point is in the middle.
[[nodiscard]] ImageSize sizeAround(const AnyCamera& camera);

/// Unknown keys, things left open, the image's size, digits that were cut off, and coefficients that look as
/// if they stood in another order.
[[nodiscard]] std::vector<Diagnosis> checkStatement(const FileClaims& claims);

}  // namespace alidade
