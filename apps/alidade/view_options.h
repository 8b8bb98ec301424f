// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/core/degrees.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"
#include "flags.h"

namespace alidade {

/// Flags for the output view of commands that make undistorted images.
struct ViewOptions {
  std::string projection = "rectilinear";
  double fov_deg = 0;
  std::string keep;               ///< all, valid or empty
  std::optional<ImageSize> size;  ///< nothing: that of the input
  std::string interpolation = "linear";
  bool may_overwrite = false;

  /// The flags --projection, --fov, --keep, --size, --interpolation and --overwrite.
  /// @param projection_help  effect of the projection in this command
  /// @param size_help  default of --size
  void addOptions(Flags& flags, const std::string& projection_help, const std::string& size_help);
  /// @throws Error (kUsage) for flags that exclude each other
  void checkUsage(const Flags& flags) const;
  /// The view that the flags of all commands request.
  [[nodiscard]] ViewRequest request(const Flags& flags) const {
    return {.projection = projectionOf(projection),
            .extent = extent(flags),
            .horizontal_field_rad = fov_deg / kDegPerRad,
            .size = size};
  }
  [[nodiscard]] Interpolation interpolationKind() const {
    return interpolation == "cubic" ? Interpolation::kCubic : Interpolation::kLinear;
  }

 private:
  [[nodiscard]] ViewExtent extent(const Flags& flags) const;
};

}  // namespace alidade
