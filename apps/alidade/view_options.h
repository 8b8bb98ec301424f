// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/core/degrees.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"
#include "flags.h"

namespace alidade {

/// The flags for views of commands that make images without distortion.
struct ViewOptions {
  std::string projection = "rectilinear";
  double fov_deg = 0;
  std::string keep;               ///< all, valid or empty
  std::optional<ImageSize> size;  ///< none: of the input
  std::string interpolation = "linear";
  bool may_overwrite = false;

  /// The flags --projection, --fov, --keep, --size, --interpolation and --overwrite.
  /// @param projection_help  what the projection does for the command
  /// @param size_help  what --size is without the flag
  void addOptions(Flags& flags, const std::string& projection_help, const std::string& size_help);
  /// @throws Error (kUsage) for flags that exclude each other
  void checkUsage(const Flags& flags) const;
  /// Fills in what requests of all commands have in common.
  template <class Request>
  [[nodiscard]] Request request(const Flags& flags) const {
    Request request;
    request.projection = projectionOf(projection);
    request.extent = extent(flags);
    request.horizontal_field_rad = fov_deg / kDegPerRad;
    request.size = size;
    return request;
  }
  [[nodiscard]] Interpolation interpolationKind() const {
    return interpolation == "cubic" ? Interpolation::kCubic : Interpolation::kLinear;
  }

 private:
  [[nodiscard]] ViewExtent extent(const Flags& flags) const;
};

}  // namespace alidade
