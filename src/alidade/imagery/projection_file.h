// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/imagery/output_view.h"

namespace alidade {

/// What an image without distortion shows, for the projections that no camera file describes.
struct ProjectionFile {
  OutputView view;  ///< cylindrical or equirectangular, with equal scales
  std::string created_by;
};

/// The file as text, with rays of pixels all over the image as a self check, and every number in the fewest
/// digits that read back as the same double. @throws std::logic_error for a rectilinear view
[[nodiscard]] std::string projectionFileText(const ProjectionFile& file);

/// Writes atomically. @throws Error (kInput)
void writeProjectionFile(const std::string& path, const ProjectionFile& file);

}  // namespace alidade
