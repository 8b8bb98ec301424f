// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/imagery/output_view.h"

namespace alidade {

/// Description of an image without distortion, for projections that no camera file can describe.
struct ProjectionFile {
  OutputView view;  ///< cylindrical or equirectangular, with equal scales
  std::string created_by;
};

/// The file as text. Rays of pixels all over the image serve as a self check. Numbers have the fewest digits
/// that read back as the same double.
/// @throws std::logic_error for a rectilinear view
[[nodiscard]] std::string projectionFileText(const ProjectionFile& file);

/// Writes atomically. @throws Error (kInput)
void writeProjectionFile(const std::string& path, const ProjectionFile& file);

}  // namespace alidade
