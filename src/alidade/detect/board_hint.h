// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "alidade/detect/detect_images.h"

namespace alidade {

/// A board size that images do show where the one asked for was not found.
struct BoardHint {
  int columns = 0;
  int rows = 0;
  int num_images = 0;  ///< images that show it
  int num_looked_at = 0;
};

/// Looks for the usual slips in a board's size (squares counted instead of inner corners, sides swapped, one
/// off) in a few of the images, spread evenly over them. Nothing if none of those sizes is there.
[[nodiscard]] std::optional<BoardHint> guessBoardSize(
    std::span<const std::string> images, const std::function<SourceImage(const std::string&)>& load,
    const Checkerboard& asked, const DetectImagesOptions& options);

}  // namespace alidade
