// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/core/degrees.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"
#include "command.h"

namespace alidade {

/// Flags for the output view of commands that make undistorted images.
struct ViewOptions {
  std::string projection = "rectilinear";
  double fov_deg = 0;
  std::string keep;  ///< all, valid or empty
  std::string size;  ///< "1280x720"; empty: as the input
  std::string interpolation = "linear";
  bool may_overwrite = false;

  /// The flags --projection, --fov, --keep, --size, --interpolation and --overwrite.
  /// @param projection_help  effect of the projection in this command
  /// @param size_help  default of --size
  void addOptions(Flags& flags, const std::string& projection_help, const std::string& size_help);
  /// @throws Error (kUsage) for flags that exclude each other
  void checkUsage(const Flags& flags) const;
  /// Sets the fields that requests of all commands share.
  template <class Request>
  [[nodiscard]] Request request(const Flags& flags) const {
    Request request;
    request.projection = projectionOf(projection);
    request.extent = extent(flags);
    request.horizontal_field_rad = fov_deg / kDegPerRad;
    request.size = parseSize(size);
    return request;
  }
  [[nodiscard]] Interpolation interpolationKind() const {
    return interpolation == "cubic" ? Interpolation::kCubic : Interpolation::kLinear;
  }

 private:
  [[nodiscard]] ViewExtent extent(const Flags& flags) const;
};

}  // namespace alidade
